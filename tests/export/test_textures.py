"""Textures of packed codes, as exported shaders read them."""

import numpy as np
import pytest
from tests import mixtures
from tests.export import gpu
from tests.export.conftest import texture_of
from tests.export.test_shaders import TABLE_TOLERANCE, basis_of

from urushi.errors import ParameterError
from urushi.export.program import codes_text
from urushi.textures import gpu as texture_files
from urushi.textures.store import TexelGrid

WIDTH, HEIGHT = 8, 4

#: The place of the texture in uv: its coordinates are (0.5 u + 0.1, v).
PLACE = ((0.5, 0.0, 0.1), (0.0, 1.0, 0.0))
GRID = TexelGrid(WIDTH, HEIGHT)

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


@pytest.mark.parametrize("eta", [1.5, 0.7])
@pytest.mark.parametrize("networks_of", ["model", "anisotropic_model"])
def test_look_up_in_opengl(networks_of, eta, request):
    """At the centre of each texel, f and pdf are those of the texel's code."""
    model = request.getfixturevalue(networks_of)
    packed = texture_of(model, eta)
    text = codes_text(
        "glsl", model, "urushi", texture_files.texels(packed)._replace(to_texture=PLACE)
    )
    codes, networks = packed.codes(), model.networks
    wi, wo = np.float32([0.6, 0.0, 0.8]), np.float32([-0.5, 0.1, 0.86])
    wo /= np.linalg.norm(wo)
    y, x = np.divmod(np.arange(WIDTH * HEIGHT), WIDTH)
    uv = np.stack([((x + 0.5) / WIDTH - 0.1) / 0.5, (y + 0.5) / HEIGHT], axis=-1)
    rows = np.hstack([np.tile(wi, (len(uv), 1)), np.tile(wo, (len(uv), 1)), uv])
    image = texture_files.texture_image(packed, GRID).texels
    textures = {"texels": image, "table": basis_of(model)}
    layout = "3f 3f 2f", "wi", "wo", "uv"
    result = gpu.in_opengl(text + MAIN, rows, layout, {"f": 3, "pdf": 1}, textures)
    expected = networks.f(codes, wi, wo)
    np.testing.assert_allclose(result[:, :3], expected, rtol=TABLE_TOLERANCE)
    pdf = mixtures.pdf(networks.proposal(codes.mean(axis=1), wi[None]), wi[None], wo[None])
    np.testing.assert_allclose(result[:, 3], pdf, rtol=1e-4)


WGSL = """
@group(0) @binding(0) var texels: texture_2d_array<f32>;
@group(0) @binding(1) var filtering: sampler;
@group(0) @binding(2) var table: texture_3d<f32>;
@fragment fn main(@location(0) uv: vec2f) -> @location(0) vec4f {
    let up = vec3f(0.0, 0.0, 1.0);
    return vec4f(urushi_f(urushi_fetch(texels, filtering, uv), up, up, table, filtering), 1.0);
}
"""
HLSL = """
Texture2DArray<float4> texels; Texture3D<float4> table; SamplerState filtering;
[shader("fragment")] float4 main(float2 uv : TEXCOORD0) : SV_Target {
    float3 up = float3(0.0, 0.0, 1.0);
    return float4(urushi_f(urushi_fetch(texels, filtering, uv), up, up, table, filtering), 1.0);
}
"""


@pytest.mark.parametrize("compiler", ["tint", "naga", "hlsl", "slang"])
def test_look_up_compiles(model, packed, tmp_path, compiler):
    language = compiler if compiler in ("hlsl", "slang") else "wgsl"
    text = codes_text(language, model, "urushi", texture_files.texels(packed))
    if language == "wgsl":
        gpu.check_wgsl(compiler, text + WGSL, tmp_path)
    else:
        gpu.translated(language, text + HLSL, "fragment")


def test_textures_need_array_textures(model, packed):
    texels = texture_files.texels(packed)
    with pytest.raises(
        ParameterError, match="exported OSL code reads no latent textures; choose one of glsl, wgsl"
    ):
        codes_text("osl", model, "urushi", texels)
