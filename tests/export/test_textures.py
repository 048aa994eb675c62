"""Texture files of packed codes, and their look-up by exported shaders."""

import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests import mixtures
from tests.export import gpu
from tests.export.test_shaders import TABLE_TOLERANCE, basis_of

from urushi.app.cli import main
from urushi.errors import ParameterError
from urushi.export.program import codes_text
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.textures import gpu as texture_files
from urushi.textures.store import TexelGrid, Texture, write_texture

WIDTH, HEIGHT = 8, 4

#: The place of the texture in uv: its coordinates are (0.5 u + 0.1, v).
PLACE = ((0.5, 0.0, 0.1), (0.0, 1.0, 0.0))
GRID = TexelGrid(WIDTH, HEIGHT, PLACE, "clamp")

MAIN = """
uniform sampler2DArray texels;
uniform highp sampler3D table;
in vec3 wi; in vec3 wo; in vec2 uv;
out vec3 f; out float pdf;
void main() {
    UrushiMaterial material = urushi_fetch(texels, uv);
    f = urushi_f(material, wi, wo, table);
    pdf = urushi_pdf(material, wi, wo);
}
"""


@pytest.fixture(scope="module")
def packed(model) -> Texture:
    return texture_of(model)


def texture_of(model: Model, eta: float = 1.5) -> Texture:
    """A texture; some numbers are constant, or the same in all channels.

    eta: of the interfaces of half of the texels; the others have 1.5.
    """
    rng = np.random.default_rng(2)
    codes = rng.normal(size=(WIDTH * HEIGHT, 3, model.arch.latent)).astype(np.float32)
    codes[..., 0] = rng.uniform(0.1, 0.4, (len(codes), 1))
    codes[..., 1:6] = 0, 0, 1, 1.5, 0
    codes[::2, :, 4] = eta
    if model.widths == 2:
        codes[..., 6] = rng.uniform(0.1, 0.4, (len(codes), 1))
        codes[..., -1] = 0.25  # the stretch
    return Texture.of(model, codes)


def image_of(packed: Texture, layers: int) -> np.ndarray:
    """Bytes (layers, height, width, 4)."""
    texels = packed.packed.bytes[:, : 4 * layers].reshape(HEIGHT, WIDTH, layers, 4)
    return texels.transpose(2, 0, 1, 3)


def read_dds(content: bytes) -> np.ndarray:
    """The texels of a DDS file with the extended header: layer by layer."""
    assert content[:4] == b"DDS " and content[84:88] == b"DX10"
    size, _, height, width, _, _, count = struct.unpack_from("<7I", content, 4)
    kind, dimension, _, layers, _ = struct.unpack_from("<5I", content, 128)
    assert (size, kind, dimension, count) == (124, 28, 3, 1)
    return np.frombuffer(content, np.uint8, offset=148).reshape(layers, height, width, 4)


def read_ktx2(content: bytes) -> np.ndarray:
    """The texels of a KTX2 file; its index gives their place."""
    assert content[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    numbers = struct.unpack_from("<9I", content, 12)
    kind, _, width, height, _, layers, faces, count, compression = numbers
    assert (kind, faces, count, compression) == (37, 1, 1, 0)
    start, length = struct.unpack_from("<2I", content, 48)
    assert start == 104 and struct.unpack_from("<I", content, start) == (length,)
    offset, size, _ = struct.unpack_from("<3Q", content, 80)
    assert offset % 4 == 0 and offset >= start + length and offset + size == len(content)
    return np.frombuffer(content, np.uint8, size, offset).reshape(layers, height, width, 4)


@pytest.mark.parametrize("kind", ["dds", "ktx2"])
def test_files_hold_all_texels(packed, kind):
    writer, reader = {
        "dds": (texture_files.dds, read_dds),
        "ktx2": (texture_files.ktx2, read_ktx2),
    }[kind]
    read = reader(writer(texture_files.texture_image(packed, GRID)))
    assert np.array_equal(read, image_of(packed, len(read)))


def test_dds_is_read_by_another_program(packed, tmp_path):
    """Pillow reads the first layer."""
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    path = tmp_path / "texture.dds"
    path.write_bytes(texture_files.dds(texture_files.texture_image(packed, GRID)))
    with image.open(path) as opened:
        assert np.array_equal(np.asarray(opened), image_of(packed, 1)[0])


@pytest.mark.parametrize("eta", [1.5, 0.7])
@pytest.mark.parametrize("networks_of", ["model", "anisotropic_model"])
def test_look_up_in_opengl(networks_of, eta, request):
    """At the centre of each texel, f and pdf are those of the texel's code."""
    context, model = gpu.gl_context(), request.getfixturevalue(networks_of)
    packed = texture_of(model, eta)
    text = codes_text("glsl", model, "urushi", texture_files.texels(packed, GRID))
    codes = packed.codes()
    wi = np.array([0.6, 0.0, 0.8], np.float32)
    wo = np.array([-0.5, 0.1, 0.86], np.float32)
    wo /= np.linalg.norm(wo)
    networks = model.networks
    with context:
        source = "#version 330\n" + text + MAIN
        program = context.program(vertex_shader=source, varyings=["f", "pdf"])
        table = gpu.gl_texture(context, basis_of(model))
        table.use(1)
        program["table"] = 1
        image = read_ktx2(texture_files.ktx2(texture_files.texture_image(packed, GRID)))
        layers, height, width, _ = image.shape
        texture = context.texture_array((width, height, layers), 4, image.tobytes())
        texture.repeat_x = texture.repeat_y = False
        texture.use(0)
        y, x = np.divmod(np.arange(width * height), width)
        uv = np.stack([((x + 0.5) / width - 0.1) / 0.5, (y + 0.5) / height], axis=-1)
        rows = np.hstack([np.tile(wi, (len(uv), 1)), np.tile(wo, (len(uv), 1)), uv])
        inputs = context.buffer(rows.astype(np.float32))
        outputs = context.buffer(reserve=16 * len(rows))
        layout = [(inputs, "3f 3f 2f", "wi", "wo", "uv")]
        context.vertex_array(program, layout).transform(outputs, mode=context.POINTS)
        result = np.frombuffer(outputs.read(), np.float32).reshape(-1, 4)
        expected = networks.f(codes, wi, wo)
        np.testing.assert_allclose(result[:, :3], expected, rtol=TABLE_TOLERANCE)
        pdf = mixtures.pdf(networks.proposal(codes.mean(axis=1), wi[None]), wi[None], wo[None])
        np.testing.assert_allclose(result[:, 3], pdf, rtol=1e-4)


@pytest.mark.parametrize(
    "language, compiler", [("wgsl", "tint"), ("wgsl", "naga"), ("hlsl", ""), ("slang", "")]
)
def test_look_up_compiles(model, packed, tmp_path, language, compiler):
    path = shutil.which(compiler)
    if language == "wgsl" and path is None:
        pytest.skip(f"{compiler} is not installed")
    texels = texture_files.texels(packed, TexelGrid(WIDTH, HEIGHT, PLACE))
    wgsl = """
@group(0) @binding(0) var texels: texture_2d_array<f32>;
@group(0) @binding(1) var filtering: sampler;
@group(0) @binding(2) var table: texture_3d<f32>;
@fragment fn main(@location(0) uv: vec2f) -> @location(0) vec4f {
    let up = vec3f(0.0, 0.0, 1.0);
    return vec4f(urushi_f(urushi_fetch(texels, filtering, uv), up, up, table, filtering), 1.0);
}
"""
    hlsl = """
Texture2DArray<float4> texels; Texture3D<float4> table; SamplerState filtering;
[shader("fragment")] float4 main(float2 uv : TEXCOORD0) : SV_Target {
    float3 up = float3(0.0, 0.0, 1.0);
    return float4(urushi_f(urushi_fetch(texels, filtering, uv), up, up, table, filtering), 1.0);
}
"""
    text = codes_text(language, model, "urushi", texels) + (wgsl if language == "wgsl" else hlsl)
    if language != "wgsl":
        gpu.translated(language, text, "fragment")
        return
    source = tmp_path / "texture.wgsl"
    source.write_text(text)
    options = ["--format", "wgsl"] if compiler == "tint" else []
    done = subprocess.run([path, *options, source], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_command_writes_shader_and_texture(model, packed, tmp_path, capsys):
    networks, stored = tmp_path / "weights.safetensors", tmp_path / "texture.safetensors"
    weights.save(networks, model.arch, model.params, {})
    grid = TexelGrid(WIDTH, HEIGHT, PLACE, "mirror")
    write_texture(stored, packed, grid, model.fingerprint)
    given = ["-l", "hlsl", "--weights", str(networks), "-o", str(tmp_path / "texture.hlsl")]
    given = ["export", str(stored), *given]
    assert main([*given, "--texture", str(tmp_path / "texture.ktx2")]) == 0
    text, table, texture = (Path(line) for line in capsys.readouterr().out.split())
    assert texture.read_bytes() == texture_files.ktx2(texture_files.texture_image(packed, GRID))
    basis = texture_files.Image(basis_of(model), is_volume=True)
    assert table.read_bytes() == texture_files.ktx2(basis)
    shader = codes_text("hlsl", model, "urushi", texture_files.texels(packed, grid))
    assert text.read_text() == shader and "mirrored repeat" in shader


def test_textures_need_array_textures(model, packed):
    texels = texture_files.texels(packed, TexelGrid(WIDTH, HEIGHT))
    with pytest.raises(
        ParameterError, match="exported OSL code reads no latent textures; choose one of glsl, wgsl"
    ):
        codes_text("osl", model, "urushi", texels)
