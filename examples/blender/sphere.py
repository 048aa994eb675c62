"""Render a sphere of an exported material in Blender: `python sphere.py lights.osl IMAGE.exr`.

Needs Blender's module bpy. The shader computes the light of a sun by itself and emits it, because
Cycles has no closure for the material. The camera looks along the world's y axis, in parallel rays.
"""

import sys
from pathlib import Path

import bpy

SUN, IRRADIANCE = (1.0, -2.0, 2.0), (1.5, 1.5, 1.5)
SIZE = 256

#: Side of the square that the picture shows; the sphere has radius 1.
WIDTH = 2.2


def clear() -> bpy.types.Scene:
    """The scene without objects, rendered by Cycles with OSL."""
    resources = Path(bpy.utils.resource_path("LOCAL"))
    # Blender finds its module oslquery there
    sys.path += map(str, resources.glob("python/lib/python*/site-packages"))
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.use_denoising = False
    scene.cycles.samples, scene.cycles.max_bounces = 16, 0
    return scene


def material(source: Path) -> bpy.types.Material:
    """A material that emits what the shader computes."""
    import cycles.osl

    made = bpy.data.materials.new("lacquer")
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    script, emission = nodes.new("ShaderNodeScript"), nodes.new("ShaderNodeEmission")
    script.mode, script.filepath = "EXTERNAL", str(source.resolve())
    cycles.osl.update_script_node(script, print)
    script.inputs["Table"].default_value = str(source.with_name("material.exr").resolve())
    script.inputs["Sun"].default_value = SUN
    script.inputs["Irradiance"].default_value = (*IRRADIANCE, 1)
    links.new(script.outputs["Radiance"], emission.inputs["Color"])
    surface = nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
    links.new(emission.outputs[0], surface)
    return made


def main(source: Path, image: Path) -> None:
    """Build the scene and render it."""
    scene = clear()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=1)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material(source))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", WIDTH
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0, -4, 0), (1.5707963, 0, 0)
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(image.resolve())
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    if len(sys.argv) != 3 or not Path(sys.argv[1]).is_file():
        sys.exit("give an exported material and a picture: python sphere.py MATERIAL.osl IMAGE.exr")
    main(Path(sys.argv[1]), Path(sys.argv[2]))
