"""Materials whose f a shader reads from a table in a texture, as `Material.f` does in Python."""

import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export import gpu

from urushi.app.cli import main
from urushi.core.table import SHAPE
from urushi.errors import ParameterError
from urushi.material import Material
from urushi.nets import weights
from urushi.textures import gpu as texture_files

#: Graphics drivers may place samples in steps of 1/256 of a node's distance, over which the tables
#: of these tests change by 0.4 % at most.
TOLERANCE = 5e-3

GLSL_MAIN = """
uniform sampler3D texels;
in vec3 wi; in vec3 wo;
out vec3 f; out float pdf;
void main() { f = urushi_f(wi, wo, texels); pdf = urushi_pdf(wi, wo); }
"""

WGSL_MAIN = """
@group(0) @binding(0) var<storage, read> rows: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4f>;
@group(0) @binding(2) var texels: texture_3d<f32>;
@group(0) @binding(3) var nearby: sampler;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    let wi = rows[3 * id.x].xyz; let wo = rows[3 * id.x + 1].xyz;
    results[id.x] = vec4f(urushi_f(wi, wo, texels, nearby), urushi_pdf(wi, wo));
}
"""


def tabulated(model, channels: int, beside_lobe: bool) -> Material:
    """A material of random codes and a random table, whose neighbouring nodes differ by up to 1."""
    rng = np.random.default_rng(8)
    codes = rng.normal(size=(channels, 24)).astype(np.float32)
    codes[:, :6] = 0.3, 0.2, 0.1, 0.5, 1.5, 0.0
    logs = rng.uniform(-1, 0, (*SHAPE, channels)).astype(np.float16)
    return Material(codes, model, None, logs, beside_lobe=beside_lobe)


def run_glsl(text: str, table: np.ndarray, rows: np.ndarray) -> np.ndarray:
    context = gpu.gl_context()
    with context:
        program = context.program(
            vertex_shader="#version 330\n" + text + GLSL_MAIN, varyings=["f", "pdf"]
        )
        size = table.shape[2::-1]
        texture = context.texture3d(size, 4, table.tobytes(), dtype="f2")
        texture.filter = context.LINEAR, context.LINEAR
        texture.repeat_x = texture.repeat_y = texture.repeat_z = False
        texture.use(0)
        inputs = context.buffer(np.ascontiguousarray(rows, np.float32))
        outputs = context.buffer(reserve=16 * len(rows))
        layout = [(inputs, "3f 1x4 3f 1x4 4x4", "wi", "wo")]
        context.vertex_array(program, layout).transform(outputs, mode=context.POINTS)
        return np.frombuffer(outputs.read(), np.float32).reshape(-1, 4)


def run_wgsl(text: str, table: np.ndarray, rows: np.ndarray) -> np.ndarray:
    device = gpu.wgpu_device()
    import wgpu

    size = table.shape[2::-1]
    use = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.create_texture(size=size, dimension="3d", format="rgba16float", usage=use)
    layout = {"bytes_per_row": 8 * size[0], "rows_per_image": size[1]}
    device.queue.write_texture({"texture": texture}, table.tobytes(), layout, size)
    storage = wgpu.BufferUsage.STORAGE
    inputs = device.create_buffer_with_data(data=rows.tobytes(), usage=storage)
    outputs = device.create_buffer(size=16 * len(rows), usage=storage | wgpu.BufferUsage.COPY_SRC)
    pipeline = device.create_compute_pipeline(
        layout="auto",
        compute={"module": device.create_shader_module(code=text + WGSL_MAIN)},
    )
    resources = (
        {"buffer": inputs},
        {"buffer": outputs},
        texture.create_view(),
        device.create_sampler(mag_filter="linear", min_filter="linear"),
    )
    entries = [{"binding": i, "resource": resource} for i, resource in enumerate(resources)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    run = encoder.begin_compute_pass()
    run.set_pipeline(pipeline)
    run.set_bind_group(0, group)
    run.dispatch_workgroups(len(rows) // 64)
    run.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(outputs), np.float32).reshape(-1, 4)


@pytest.mark.parametrize("run", [run_glsl, run_wgsl])
@pytest.mark.parametrize("channels, beside_lobe", [(3, False), (1, True)])
def test_shaders_read_the_table(model, rows, run, channels, beside_lobe):
    material = tabulated(model, channels, beside_lobe)
    text = material.shader(run.__name__.removeprefix("run_"), table=True)
    found = run(text, texture_files.table_image(material.table).levels[0], rows)
    wi, wo = rows[:, :3], rows[:, 4:7]
    expected = np.broadcast_to(material.f(wi, wo), (len(rows), 3))
    np.testing.assert_allclose(found[:, :3], expected, rtol=TOLERANCE)
    np.testing.assert_allclose(found[:, 3], material.pdf(wi, wo), rtol=1e-4)


@pytest.mark.parametrize("language", ["hlsl", "slang"])
def test_files_in_other_languages_compile(model, tmp_path, language):
    source = tmp_path / f"table.{language}"
    source.write_text(
        tabulated(model, 3, True).shader(language, table=True)
        + """
Texture3D<float4> texels; SamplerState nearby;
[shader("fragment")] float4 main(float3 w : TEXCOORD0) : SV_Target {
    return float4(urushi_f(w, w, texels, nearby), urushi_pdf(w, w));
}
"""
    )
    options = ["-lang", language, "-target", "wgsl", "-entry", "main", "-stage", "fragment"]
    done = subprocess.run([gpu.slangc(), *options, source], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_files_hold_the_table(model):
    table = tabulated(model, 3, False).table
    image = texture_files.table_image(table)
    dds, ktx2 = texture_files.dds(image), texture_files.ktx2(image)
    size, _, height, width, pitch, depth, count = struct.unpack_from("<7I", dds, 4)
    assert (size, pitch, count) == (124, 8 * width, 1)
    assert struct.unpack_from("<5I", dds, 128) == (10, 4, 0, 1, 0)  # RGBA16F, a 3D texture
    kind, unit, *sizes, layers, faces, levels, _ = struct.unpack_from("<9I", ktx2, 12)
    assert (kind, unit, layers, faces, levels) == (97, 2, 0, 1, 1)
    assert sizes == [width, height, depth] == [*SHAPE[::-1]]
    offset, length, _ = struct.unpack_from("<3Q", ktx2, 80)
    assert offset % 8 == 0  # the size of a texel
    for content, start in ((dds, 148), (ktx2, offset)):
        texels = np.frombuffer(content, np.float16, offset=start).reshape(*SHAPE, 4)
        assert np.array_equal(texels[..., :3], table)
    assert offset + length == len(ktx2)


def test_command_writes_shader_and_table(model, tmp_path, capsys):
    material, networks = tabulated(model, 3, True), tmp_path / "weights.safetensors"
    weights.save(networks, model.arch, model.params, {})
    material.save(tmp_path / "paint.safetensors")
    given = ["-l", "wgsl", "--weights", str(networks), "-o", str(tmp_path / "paint.wgsl")]
    given += ["--texture", str(tmp_path / "paint.dds")]
    assert main(["export", str(tmp_path / "paint.safetensors"), *given]) == 0
    texture, text = (Path(line) for line in capsys.readouterr().out.split())
    assert texture.read_bytes() == texture_files.dds(texture_files.table_image(material.table))
    assert text.read_text() == material.shader("wgsl", table=True)
    Material(material.latents, model).save(tmp_path / "codes.safetensors")
    assert main(["export", str(tmp_path / "codes.safetensors"), *given]) == 2
    assert "only latent textures and tables of materials" in capsys.readouterr().err


def test_errors_name_the_cure(model):
    material = tabulated(model, 3, False)
    with pytest.raises(ParameterError, match="exported Python code reads no textures; choose one"):
        material.shader("python", table=True)
    with pytest.raises(ParameterError, match="has no table; leave out table=True"):
        Material(material.latents, model).shader("glsl", table=True)
