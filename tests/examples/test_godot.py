"""The example for Godot: the picture agrees with `Material.f`."""

import os
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from urushi.core.error_metrics import shown

EXAMPLE = Path(__file__).parents[2] / "examples" / "godot"

#: From the scene: towards the lamp, its energy, the camera's height and field of view.
LAMP, ENERGY, DISTANCE, FOV = np.array([0.48, 0.6, 0.64]), 0.5, 4.0, np.radians(35.0)


def in_frame(w: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Directions (N, 3) in frames about normals (N, 3); f is isotropic."""
    other = np.where(np.abs(normal[:, :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    tangent = np.cross(normal, other)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    axes = (tangent, np.cross(normal, tangent), normal)
    local = np.stack([(w * axis).sum(axis=1) for axis in axes], axis=1)
    return local / np.linalg.norm(local, axis=1, keepdims=True)


@pytest.mark.slow
def test_the_picture_is_that_of_f(tmp_path):
    """To four of 255 steps: Godot 3.2 rounds the weights of the shader to six digits."""
    if not (shutil.which("godot3") and shutil.which("xvfb-run")):
        pytest.skip("godot3 or xvfb-run is not installed")
    from PIL import Image

    material = runpy.run_path(str(EXAMPLE.parent / "material.py"))["lacquer"]()
    for name in ("project.godot", "sphere.tscn", "sphere.gd"):
        shutil.copy(EXAMPLE / name, tmp_path)
    subprocess.run([sys.executable, EXAMPLE / "shader.py", tmp_path], check=True)
    command = ["xvfb-run", "-a", "-s", "-screen 0 640x480x24", "godot3", "--path", tmp_path]
    done = subprocess.run(
        [*command, "--audio-driver", "Dummy"],
        env=os.environ | {"HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert "SHADER ERROR" not in done.stdout + done.stderr
    seen = np.asarray(Image.open(tmp_path / "sphere.png").convert("RGB")) / 255.0
    size = len(seen)
    place = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(FOV / 2)
    x, y = np.meshgrid(place, -place)
    ray = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    along = -DISTANCE * ray[:, 2]
    root = along**2 - (DISTANCE**2 - 1)
    point = [0, 0, DISTANCE] + (along - np.sqrt(np.maximum(root, 0)))[:, None] * ray
    # Triangles of the sphere differ from it near the outline.
    inside = (root > 0) & ((point * -ray).sum(axis=1) > 0.15) & (point @ LAMP > 0.15)
    normal = point[inside]
    wi, wo = in_frame(-ray[inside], normal), in_frame(np.tile(LAMP, (len(normal), 1)), normal)
    linear = np.pi * ENERGY * material.f(wi, wo) * wo[:, 2:]
    difference = np.abs(shown(linear) - seen.reshape(-1, 3)[inside])
    assert inside.sum() > 20_000
    assert difference.max() < 5 / 255
    assert difference.mean() < 1 / 255
