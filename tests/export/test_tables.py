"""Texture files of tables of ln f, and the command that writes them."""

import struct
from pathlib import Path

import numpy as np
import pytest
from tests.export.test_shaders import basis_of

from urushi.app.cli import main
from urushi.core.table import SHAPE
from urushi.export.rest import TextureForm, basis_texture
from urushi.nets import weights
from urushi.textures import gpu


def test_a_texture_has_the_table_in_the_opposite_order(materials):
    table = materials["table"].table
    assert np.array_equal(materials["table"].shader_texture()[..., :3], table)
    flat = materials["table"].shader_texture("osl").reshape(SHAPE[0], SHAPE[2], SHAPE[1], 3)
    assert np.array_equal(flat.swapaxes(1, 2), table)


@pytest.mark.parametrize("form", [TextureForm(), TextureForm(2, 3)])
def test_blocks_of_a_texture_hold_the_functions_of_the_basis(model, form):
    """At each node b and the functions but the first, which is one."""
    basis = model.networks.basis
    texture = basis_texture(model, form)
    numbers = texture.reshape(*SHAPE[: form.axes - 1], -1, SHAPE[form.axes - 1], form.numbers)
    numbers = np.moveaxis(numbers, form.axes - 1, -2)  # ..., blocks, numbers
    if form.axes == 2:
        blocks = numbers.reshape(*SHAPE[:2], -1, SHAPE[2], form.numbers)
        numbers = blocks.swapaxes(2, 3)
    rows = numbers.reshape(len(basis.rows), -1)[:, : basis.size]
    assert (basis.rows[:, 1] == 1).all()
    assert np.array_equal(rows, np.delete(basis.rows, 1, axis=1))


def test_files_hold_the_table(materials):
    texture = materials["table"].shader_texture()
    image = gpu.Image(texture, is_volume=True)
    dds, ktx2 = gpu.dds(image), gpu.ktx2(image)
    size, _, height, width, pitch, depth, count = struct.unpack_from("<7I", dds, 4)
    assert (size, pitch, count) == (124, 8 * width, 1)
    assert struct.unpack_from("<5I", dds, 128) == (10, 4, 0, 1, 0)  # RGBA16F, a 3D texture
    kind, unit, *sizes, layers, faces, levels, _ = struct.unpack_from("<9I", ktx2, 12)
    assert (kind, unit, layers, faces, levels) == (97, 2, 0, 1, 1)
    assert sizes == [width, height, depth] == [*SHAPE[::-1]]
    offset, length, _ = struct.unpack_from("<3Q", ktx2, 80)
    assert offset % 8 == 0  # the size of a texel
    for content, start in ((dds, 148), (ktx2, offset)):
        texels = np.frombuffer(content, np.float16, offset=start)
        assert np.array_equal(texels, texture.ravel())
    assert offset + length == len(ktx2)


@pytest.mark.parametrize("language, suffix", [("wgsl", "dds"), ("osl", "exr"), ("python", "npy")])
def test_command_writes_shader_and_texture(model, materials, tmp_path, capsys, language, suffix):
    networks = tmp_path / "weights.safetensors"
    weights.save(networks, model.arch, model.params, {})
    material = materials["table"]
    material.save(tmp_path / "paint.safetensors")
    given = ["-l", language, "--weights", str(networks), "-o", str(tmp_path / "paint.txt")]
    assert main(["export", str(tmp_path / "paint.safetensors"), *given]) == 0
    text, texture = (Path(line) for line in capsys.readouterr().out.split())
    assert text.read_text() == material.shader(language)
    assert np.array_equal(read(texture), material.shader_texture(language))
    assert main(["export", *given, "--texture", str(tmp_path / f"all.{suffix}")]) == 0
    assert np.array_equal(read(tmp_path / f"all.{suffix}"), basis_of(model, language))
    assert main(["export", *given, "--texture", str(tmp_path / "all.png")]) == 2
    assert f"reads no texture files '.png'; give a name with .{suffix}" in capsys.readouterr().err


def read(path: Path) -> np.ndarray:
    """A texture of a file."""
    if path.suffix == ".npy":
        return np.load(path)
    if path.suffix == ".exr":
        import mitsuba as mi

        return np.array(mi.Bitmap(str(path)))
    content = path.read_bytes()
    height, width, _, depth = struct.unpack_from("<4I", content, 12)
    return np.frombuffer(content, np.float16, offset=148).reshape(depth, height, width, 4)
