"""Files of exported textures, DDS and KTX2, and the command that writes them beside the code."""

import struct
from pathlib import Path

import numpy as np
import pytest
from tests.export.test_shaders import basis_of

from urushi.app.cli import main
from urushi.core.table import SHAPE
from urushi.export.program import codes_text
from urushi.export.rest import TextureForm, basis_texture
from urushi.nets import weights
from urushi.textures import gpu
from urushi.textures.store import TexelGrid, write_texture

#: The types of texels by the numbers of their formats, RGBA8 and RGBA16F, in both kinds of files.
DDS_TYPES, KTX2_TYPES = {28: np.uint8, 10: np.float16}, {37: np.uint8, 97: np.float16}


def read_dds(content: bytes) -> gpu.Image:
    """The image of a DDS file with the extended header."""
    assert content[:4] == b"DDS " and content[84:88] == b"DX10"
    size, _, height, width, pitch, depth, count = struct.unpack_from("<7I", content, 4)
    kind, dimension, _, layers, _ = struct.unpack_from("<5I", content, 128)
    texels = np.frombuffer(content, DDS_TYPES[kind], offset=148)
    texels = texels.reshape(max(depth, layers), height, width, 4)
    assert (size, count, pitch) == (124, 1, texels[0, 0].nbytes) and (depth == 0 or layers == 1)
    return gpu.Image(texels, is_volume={4: True, 3: False}[dimension])


def read_ktx2(content: bytes) -> gpu.Image:
    """The image of a KTX2 file; its index gives the texels' place."""
    assert content[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    numbers = struct.unpack_from("<9I", content, 12)
    kind, unit, width, height, depth, layers, faces, count, compression = numbers
    assert (faces, count, compression) == (1, 1, 0) and (depth == 0 or layers == 0)
    start, length = struct.unpack_from("<2I", content, 48)
    assert start == 104 and struct.unpack_from("<I", content, start) == (length,)
    offset, size, _ = struct.unpack_from("<3Q", content, 80)
    texels = np.frombuffer(content, KTX2_TYPES[kind], offset=offset)
    texels = texels.reshape(max(depth, layers), height, width, 4)
    assert unit == texels.itemsize and offset % texels[0, 0, 0].nbytes == 0
    assert offset >= start + length and offset + size == len(content)
    return gpu.Image(texels, is_volume=depth > 0)


def read(path: Path) -> np.ndarray:
    """A texture of a file."""
    if path.suffix == ".npy":
        return np.load(path)
    if path.suffix == ".exr":
        import mitsuba as mi

        return np.array(mi.Bitmap(str(path)))
    return {".dds": read_dds, ".ktx2": read_ktx2}[path.suffix](path.read_bytes()).texels


@pytest.fixture(params=["codes", "table"])
def image(request, packed, materials) -> gpu.Image:
    """A texture of codes, of layers, or of ln f, in space."""
    if request.param == "codes":
        return gpu.texture_image(packed, TexelGrid(8, 4))
    return gpu.Image(materials["table"].shader_texture(), is_volume=True)


@pytest.mark.parametrize(("write", "read"), [(gpu.dds, read_dds), (gpu.ktx2, read_ktx2)])
def test_files_hold_all_texels(image, write, read):
    found = read(write(image))
    assert found.is_volume == image.is_volume and found.texels.dtype == image.texels.dtype
    assert np.array_equal(found.texels, image.texels)


def test_dds_is_read_by_another_program(packed, tmp_path):
    """Pillow reads the first layer, texels in the order of their rows."""
    pillow = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    path = tmp_path / "texture.dds"
    path.write_bytes(gpu.dds(gpu.texture_image(packed, TexelGrid(8, 4))))
    with pillow.open(path) as opened:
        first = packed.bytes[:, :4].reshape(4, 8, 4)
        assert np.array_equal(np.asarray(opened), first)


@pytest.mark.parametrize(
    ("language", "form"), [("glsl", TextureForm()), ("osl", TextureForm(2, 3))]
)
def test_textures_hold_the_table_and_the_functions_of_the_basis(model, materials, language, form):
    """In the opposite order; of the basis, at each node b and the functions but the first, one."""

    def at_nodes(texture: np.ndarray) -> np.ndarray:
        if form.axes == 3:
            blocks = texture.reshape(*SHAPE[:2], -1, SHAPE[2], form.numbers).swapaxes(2, 3)
        else:
            blocks = texture.reshape(SHAPE[0], -1, SHAPE[2], SHAPE[1], form.numbers)
            blocks = blocks.transpose(0, 3, 2, 1, 4)
        return blocks.reshape(*SHAPE, -1)

    table = materials["table"]
    assert np.array_equal(at_nodes(table.shader_texture(language))[..., :3], table.table)
    basis = model.networks.basis
    assert (basis.rows[:, 1] == 1).all()
    found = at_nodes(basis_texture(model, form))[..., : basis.size].reshape(-1, basis.size)
    assert np.array_equal(found, np.delete(basis.rows, 1, axis=1))


@pytest.fixture
def export(model, tmp_path, capsys):
    """From options: the status of the command with the small networks, and what it prints."""
    weights.save(tmp_path / "weights", model.arch, model.params, {})

    def run(*options) -> tuple[int, list[Path], str]:
        given = ["--weights", tmp_path / "weights", "-o", tmp_path / "code.txt", *options]
        status, printed = main(["export", *map(str, given)]), capsys.readouterr()
        return status, list(map(Path, printed.out.split())), printed.err

    return run


def test_a_folder_is_refused_as_code(export):
    status, _, error = export("-l", "wgsl", "-o", ".")
    assert status == 2 and error.startswith("urushi: cannot write '.': it is a folder; choose")


@pytest.mark.parametrize("language, suffix", [("wgsl", "dds"), ("osl", "exr"), ("python", "npy")])
def test_command_writes_materials(model, materials, tmp_path, export, language, suffix):
    for kind in ("table", "no rest"):
        materials[kind].save(tmp_path / "paint.safetensors")
        status, (text, *texture), _ = export(tmp_path / "paint.safetensors", "-l", language)
        assert status == 0 and text.read_text() == materials[kind].shader(language)
        expected = materials[kind].shader_texture(language)
        assert [path.suffix for path in texture] == [f".{suffix}"] * (expected is not None)
        assert all(np.array_equal(read(path), expected) for path in texture)
    named = tmp_path / f"all.{suffix}"
    status, (text, _), _ = export("-l", language, "--prefix", "paint", "--texture", named)
    assert status == 0 and text.read_text() == codes_text(language, model, "paint")
    assert np.array_equal(read(named), basis_of(model, language))
    status, _, error = export("-l", language, "--texture", tmp_path / "all.png")
    assert status == 2
    assert f"reads no texture files '.png'; give a name with .{suffix}" in error
    # Of two options -o the last one counts
    status, _, error = export("-l", language, "-o", tmp_path / f"new.{suffix}")
    assert status == 2 and "would replace the code" in error
    assert not (tmp_path / f"new.{suffix}").exists()


def test_no_code_is_written_without_its_texture(export, tmp_path):
    status, _, error = export("-l", "wgsl", "--texture", tmp_path / "nowhere" / "basis.dds")
    assert status == 2 and "cannot write" in error and "basis.dds" in error
    assert not (tmp_path / "code.txt").exists()


def test_command_writes_textures(model, packed, tmp_path, export):
    grid = TexelGrid(8, 4)
    write_texture(tmp_path / "codes", packed, grid, model.fingerprint)
    given = (tmp_path / "codes", "-l", "hlsl", "--texture", tmp_path / "texture.ktx2")
    status, (text, table, texture), _ = export(*given)
    shader = codes_text("hlsl", model, "urushi", gpu.texels(packed))
    assert status == 0 and text.read_text() == shader
    assert np.array_equal(read(texture), gpu.texture_image(packed, grid).texels)
    assert np.array_equal(read(table), basis_of(model))
