"""Run with Python and Blender's module bpy: render f of an OSL file at pairs of directions.

Arguments: the OSL file, which has a shader with the output f, the image to write (.npy), and its
pixels per side. The shader is the emission of the unit square, which the image shows.
"""

import sys
from pathlib import Path

import bpy
import numpy as np


def main(source: str, target: str, size: int) -> None:
    """Compile and render the file."""
    resources = Path(bpy.utils.resource_path("LOCAL"))
    packages = resources.glob("python/lib/python*/site-packages")
    sys.path += map(str, packages)  # Blender finds its module oslquery there
    import cycles.osl

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.samples, scene.cycles.max_bounces = 1, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.view_settings.view_transform = "Raw"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0.5, 0.5, 0))
    material = bpy.data.materials.new("f")
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output, emission = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeEmission")
    script = nodes.new("ShaderNodeScript")
    script.mode, script.filepath = "EXTERNAL", source
    cycles.osl.update_script_node(script, print)
    links.new(script.outputs["f"], emission.inputs["Color"])
    links.new(emission.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 1
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = 0.5, 0.5, 1
    scene.collection.objects.link(scene.camera)
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(Path(target).with_suffix(".exr"))
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:], np.float32).reshape(size, size, -1)
    np.save(target, pixels[..., :3])


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
