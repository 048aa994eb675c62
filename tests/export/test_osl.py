"""Exported OSL in the example for Blender: set BPY_PYTHON to a Python that has the module bpy.

Blender pins other packages than Urushi, so that it needs an environment of its own.
"""

import os
import runpy
import shutil
import subprocess
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from tests.export.test_shaders import basis_of

from urushi.app.export import write_table
from urushi.export.program import codes_text

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

#: Of `examples/blender/sphere.py`, which cannot be imported without bpy.
SUN, IRRADIANCE, SIZE, WIDTH = np.array([1.0, -2.0, 2.0]) / 3, 1.5, 256, 2.2

#: f by the code of all materials, as the example's shader calls it.
OF_CODES = """
color urushi_f(vector wi, vector wo, string table) {{
    color codes[{}] = {{{}}};
    return all_f(all_prepare(codes), wi, wo, table);
}}
"""


def write(folder: Path, material, in_codes: bool) -> None:
    """The file and the texture of a material, its own or those of all codes."""
    text, texture = material.shader("osl"), material.shader_texture("osl")
    if in_codes:
        numbers = [f"color{tuple(column)!r}" for column in material.latents.T.tolist()]
        text = codes_text("osl", material.model, "all")
        text += OF_CODES.format(len(numbers), ", ".join(numbers))
        texture = basis_of(material.model, "osl")
    (folder / "material.osl").write_text(text)
    write_table(folder / "material.exr", texture)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["example", "material", "codes"])
def test_the_sphere_shows_f_under_the_sun(materials, tmp_path, kind):
    python = os.environ.get("BPY_PYTHON")
    if not python:
        pytest.skip("BPY_PYTHON names no Python with Blender's module bpy")
    example = runpy.run_path(str(EXAMPLES / "material.py"))
    if kind == "example":
        material = example["lacquer"]()
        example["main"](tmp_path)
    else:
        material = materials["edges"]
        write(tmp_path, material, kind == "codes")
    shader, image = tmp_path / "lights.osl", tmp_path / "sphere.exr"
    shutil.copy(EXAMPLES / "blender" / "lights.osl", shader)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [python, EXAMPLES / "blender" / "sphere.py", shader, image],
        capture_output=True,
        text=True,
        env=environment,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    bitmap = mi.Bitmap(str(image)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
    picture = np.array(bitmap)

    # The camera looks along y, x is to the right and z is up.
    place = ((np.arange(SIZE) + 0.5) / SIZE - 0.5) * WIDTH
    x, z = (a.ravel() for a in np.meshgrid(place, -place))
    inside = x * x + z * z < 0.8  # away from the silhouette
    x, z = x[inside], z[inside]
    normal = np.stack([x, -np.sqrt(1 - x * x - z * z), z], axis=-1)
    expected = radiance(material, normal, np.array([0.0, -1.0, 0.0]), SUN) * IRRADIANCE
    found = picture.reshape(-1, 3)[inside]
    # A pixel averages over its filter, and the triangles of the sphere are 0.025 wide.
    error = abs(found - expected) / (expected + expected.mean())
    assert np.median(error) < 0.002
    assert error.max() < 0.03


def radiance(material, normal: np.ndarray, to_eye: np.ndarray, to_light: np.ndarray) -> np.ndarray:
    """f times the cosine of the light (N, 3), at normals (N, 3) of an isotropic material."""

    def local(v: np.ndarray) -> np.ndarray:
        x = np.cross(normal, (0.36, 0.48, 0.8))
        x /= np.linalg.norm(x, axis=-1, keepdims=True)
        return np.stack([x @ v, np.cross(normal, x) @ v, normal @ v], axis=-1)

    wo = local(to_light)
    return material.f(local(to_eye), wo) * np.maximum(wo[:, 2:], 0)
