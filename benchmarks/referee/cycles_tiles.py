"""Run with Python and Blender's module bpy: f of Cycles' Principled BSDF by pictures of tiles.

Arguments: a file (.npz) of `wi` and `wo` (N, 3), `sun` (N,) the number of the angle between them,
directions `lit` (C, 3), and JSON `materials`, the sockets of each of M nodes by name; and the file
to write (.npy): f (M, N, 3), then albedos (M, C, 3) in the rows that follow.

A tile stands for a pair: it is tilted so that the camera, which looks straight down from far away,
sees it along wi, and turned so that the sun of its pair shines along wo. There is one picture for
each angle between both, and one under a white sky for the albedos.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np

#: Samples of a pixel under the white sky.
SKY_SAMPLES = 2048


def frames(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Rotations (N, 3, 3) that carry wi to z, and wo into the xz plane."""
    across = wo - (wi * wo).sum(1, keepdims=True) * wi
    x = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    return np.stack([x, np.cross(wi, x), wi], axis=1)


def tiles(turn: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Corners (N, 4, 3) of tiles with the normals turn[:, :, 2], each of which fills a pixel."""
    normal, up = turn[:, :, 2], np.array([0.0, 0.0, 1.0])
    side = np.cross(up, normal)
    flat = np.linalg.norm(side, axis=1) < 1e-6
    side[flat] = (1.0, 0.0, 0.0)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    steep = np.cross(normal, side) / normal[:, 2:]
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.5
    local = signs[:, 0, None] * side[:, None] + signs[:, 1, None] * steep[:, None]
    return centres[:, None] + local


def set_up(size: tuple[int, int]) -> "bpy.types.Scene":
    """A scene of Cycles without light, seen from above; a pixel is one unit."""
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene.render.engine = "CYCLES"
    scene.cycles.max_bounces = 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.cycles.blur_glossy, scene.cycles.pixel_filter_type = 0, "BOX"
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", max(size), 1000
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = size[0] / 2, size[1] / 2, 500
    scene.collection.objects.link(scene.camera)
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    return scene


def row(name: str, sockets: dict, corners: np.ndarray) -> None:
    """An object of tiles (N, 4, 3) of one material, which neither shade nor light each other."""
    mesh = bpy.data.meshes.new(name)
    faces = np.arange(4 * len(corners)).reshape(-1, 4)
    mesh.from_pydata(corners.reshape(-1, 3).tolist(), [], faces.tolist())
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    for key, value in sockets.items():
        node.inputs[key].default_value = value
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    thing.visible_shadow = thing.visible_diffuse = thing.visible_glossy = False
    bpy.context.scene.collection.objects.link(thing)


def picture(path: Path) -> np.ndarray:
    """Radiance (H, W, 3), the lowest row first."""
    scene = bpy.context.scene
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    size = scene.render.resolution_y, scene.render.resolution_x
    found = np.array(image.pixels[:], np.float32).reshape(*size, -1)[..., :3]
    bpy.data.images.remove(image)
    return found


def main(source: str, target: str) -> None:
    given = np.load(source)
    wi, wo, lit = (given[name].astype(float) for name in ("wi", "wo", "lit"))
    materials = json.loads(str(given["materials"]))
    turn = frames(np.concatenate([wi, lit]), np.concatenate([wo, lit + np.array([0, 1, 0])]))
    scene = set_up((len(turn), max(len(materials), 4)))  # Blender's least resolution
    for i, (name, sockets) in enumerate(materials.items()):
        centres = np.stack([np.arange(len(turn)) + 0.5, np.full(len(turn), i + 0.5)], axis=-1)
        row(name, sockets, tiles(turn, np.pad(centres, ((0, 0), (0, 1)))))
    found, path = np.zeros((len(materials), len(turn), 3)), Path(target).with_suffix(".exr")
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky["Color"].default_value, sky["Strength"].default_value = (1, 1, 1, 1), 1
    scene.cycles.samples = SKY_SAMPLES
    scene.render.use_border, scene.render.border_min_x = True, len(wi) / len(turn)
    found[:, len(wi) :] = picture(path)[: len(found), len(wi) :]
    scene.render.use_border = False
    sky["Strength"].default_value, scene.cycles.samples = 0, 1
    sun = bpy.data.lights.new("sun", "SUN")
    sun.angle, sun.energy = 0, 1
    thing = bpy.data.objects.new("sun", sun)
    scene.collection.objects.link(thing)
    for number in np.unique(given["sun"]):
        own = np.flatnonzero(given["sun"] == number)
        thing.rotation_euler = 0, np.arccos(np.mean((wi[own] * wo[own]).sum(1))), 0
        found[:, own] = picture(path)[: len(found), own] / wo[own, 2:]
    np.save(target, found)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
