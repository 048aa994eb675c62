"""Exported OSL, run by Blender: set BPY_PYTHON to a Python that has Blender's module bpy.

Blender pins other packages than Urushi, so that it needs an environment of its own.
"""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export.test_shaders import TABLE_TOLERANCE, basis_of

from urushi.app.export import write_table
from urushi.export.program import codes_text

SIZE = 64

MAIN = """
vector spiral(float i, float turn) {
    float z = (i + 0.5) / 64;
    float r = sqrt(1 - z * z);
    return vector(r * cos(turn * i), r * sin(turn * i), z);
}
shader f_of_pairs(output color f = 0) {
    vector wi = spiral(floor(P[0] * 64), 0.3);
    vector wo = spiral(floor(P[1] * 64), 0.17);
    %s
}
"""


def spiral(turn: float) -> np.ndarray:
    """The directions of `MAIN`, (`SIZE`, 3)."""
    i = np.arange(SIZE)
    z = (i + 0.5) / SIZE
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn * i), r * np.sin(turn * i), z], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["material", "codes"])
def test_osl_in_cycles(model, materials, tmp_path, kind):
    python = os.environ.get("BPY_PYTHON")
    if not python:
        pytest.skip("BPY_PYTHON names no Python with Blender's module bpy")
    material, table = materials["edges"], tmp_path / "f.exr"
    if kind == "material":
        text, call = material.shader("osl"), f'f = urushi_f(wi, wo, "{table}");'
        write_table(table, material.shader_texture("osl"))
    else:
        numbers = ", ".join(
            f"color({r!r}, {g!r}, {b!r})" for r, g, b in material.latents.T.tolist()
        )
        text = codes_text("osl", model, "urushi")
        call = (
            f"color codes[{model.arch.latent}] = {{{numbers}}}; "
            f'f = urushi_f(urushi_prepare(codes), wi, wo, "{table}");'
        )
        write_table(table, basis_of(model, "osl"))
    source, image = tmp_path / "f.osl", tmp_path / "f.npy"
    source.write_text(text + MAIN % call)
    script = Path(__file__).with_name("cycles_osl.py")
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        [python, script, source, image, str(SIZE)], capture_output=True, text=True, env=environment
    )
    assert done.returncode == 0, done.stdout + done.stderr
    wi, wo = np.tile(spiral(0.3), (SIZE, 1)), np.repeat(spiral(0.17), SIZE, axis=0)
    expected = material.f(wi, wo)
    np.testing.assert_allclose(np.load(image).reshape(-1, 3), expected, rtol=TABLE_TOLERANCE)
