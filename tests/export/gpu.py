"""Running exported shaders: GLSL in OpenGL, WGSL in WebGPU, HLSL and Slang by slangc to WGSL."""

import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest

#: Columns of a row of inputs, wi, wo and u, and of outputs: f, pdf, the direction and density of
#: sample. Rows have a multiple of four floats.
INPUTS, OUTPUTS = 12, 8

GLSL_MAIN = """
uniform highp sampler3D texels;
in vec3 wi; in vec3 wo; in vec3 u;
out vec3 f; out float pdf; out vec3 direction; out float density;
void main() {{
    {prepare}
    f = urushi_f({first}wi, wo{last});
    pdf = urushi_pdf({first}wi, wo);
    UrushiSample drawn = urushi_sample({first}wi, u);
    direction = drawn.direction;
    density = drawn.density;
}}
"""

WGSL_MAIN = """
@group(0) @binding(0) var<storage, read> rows: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4f>;
@group(0) @binding(2) var texels: texture_3d<f32>;
@group(0) @binding(3) var nearby: sampler;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{
    let wi = rows[3 * id.x].xyz; let wo = rows[3 * id.x + 1].xyz; let u = rows[3 * id.x + 2].xyz;
    {prepare}
    let drawn = urushi_sample({first}wi, u);
    results[2 * id.x] = vec4f(urushi_f({first}wi, wo{last}), urushi_pdf({first}wi, wo));
    results[2 * id.x + 1] = vec4f(drawn.direction, drawn.density);
}}
"""

HLSL_MAIN = """
StructuredBuffer<float4> rows : register(t0);
RWStructuredBuffer<float4> results : register(u1);
Texture3D<float4> texels : register(t2);
SamplerState nearby : register(s3);
[shader("compute")] [numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {{
    float3 wi = rows[3 * id.x].xyz, wo = rows[3 * id.x + 1].xyz, u = rows[3 * id.x + 2].xyz;
    {prepare}
    UrushiSample drawn = urushi_sample({first}wi, u);
    results[2 * id.x] = float4(urushi_f({first}wi, wo{last}), urushi_pdf({first}wi, wo));
    results[2 * id.x + 1] = float4(drawn.direction, drawn.density);
}}
"""

#: Of a language: the entry point, the texture's arguments, and how a variable is declared.
MAINS = {
    "glsl": (GLSL_MAIN, ", texels", "UrushiMaterial"),
    "wgsl": (WGSL_MAIN, ", texels, nearby", "let"),
    "hlsl": (HLSL_MAIN, ", texels, nearby", "UrushiMaterial"),
}
MAINS["slang"] = MAINS["hlsl"]


def run(language: str, text: str, rows: np.ndarray, texture: np.ndarray | None) -> np.ndarray:
    """The `OUTPUTS` of a material's file, or of a filled template, at rows (N, `INPUTS`).

    texture: that f reads.
    """
    template, last, declared = MAINS[language]
    first = prepare = ""
    if "urushi_material()" in text:  # a filled template
        first, prepare = "material, ", f"{declared} material = urushi_material();"
    last = "" if texture is None else last
    source = text + template.format(prepare=prepare, first=first, last=last)
    if language == "glsl":
        outputs = {"f": 3, "pdf": 1, "direction": 3, "density": 1}
        textures = {} if texture is None else {"texels": texture}
        layout = "3f 1x4 3f 1x4 3f 1x4", "wi", "wo", "u"
        return in_opengl(source, rows, layout, outputs, textures)
    if language != "wgsl":
        source = translated(language, source, "compute")
    return _in_webgpu(source, rows, texture)


def in_opengl(source: str, rows: np.ndarray, layout: tuple, outputs: dict, textures: dict):
    """The outputs (N, floats) of a vertex shader at rows of float32 inputs.

    layout: of a row, as moderngl describes it: formats, then names. outputs: sizes by name.
    textures: by name, as `_gl_texture` takes them.
    """
    context = gl_context()
    with context:  # WebGPU has contexts of its own
        program = context.program(vertex_shader="#version 330\n" + source, varyings=[*outputs])
        made = {name: _gl_texture(context, texels) for name, texels in textures.items()}
        for unit, (name, texture) in enumerate(made.items()):
            texture.use(unit)
            program[name] = unit
        inputs = context.buffer(np.ascontiguousarray(rows, np.float32))
        results = context.buffer(reserve=4 * sum(outputs.values()) * len(rows))
        array = context.vertex_array(program, [(inputs, *layout)])
        array.transform(results, mode=context.POINTS)
        return np.frombuffer(results.read(), np.float32).reshape(len(rows), -1)


def _gl_texture(context, texels: np.ndarray):
    """A 3D texture of half floats; of bytes, an array of layers without repetition."""
    if texels.dtype == np.float16:
        made = context.texture3d(texels.shape[2::-1], 4, texels.tobytes(), dtype="f2")
    else:
        layers, height, width, _ = texels.shape
        made = context.texture_array((width, height, layers), 4, texels.tobytes())
        made.repeat_x = made.repeat_y = False
    made.filter = context.LINEAR, context.LINEAR
    return made


def _in_webgpu(source: str, rows: np.ndarray, texture: np.ndarray | None) -> np.ndarray:
    """The results of a compute shader in WGSL."""
    device = wgpu_device()
    import wgpu

    padded = np.zeros((-(-len(rows) // 64) * 64, INPUTS), np.float32)
    padded[:, 2] = 1.0
    padded[: len(rows)] = rows
    storage = wgpu.BufferUsage.STORAGE
    size, usage = 4 * OUTPUTS * len(padded), storage | wgpu.BufferUsage.COPY_SRC
    inputs = device.create_buffer_with_data(data=padded.tobytes(), usage=storage)
    outputs = device.create_buffer(size=size, usage=usage)
    resources = [{"buffer": inputs}, {"buffer": outputs}]
    if texture is not None:
        resources += [_wgpu_texture(device, texture).create_view()]
        resources += [device.create_sampler(mag_filter="linear", min_filter="linear")]
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": device.create_shader_module(code=source)}
    )
    entries = [{"binding": i, "resource": resource} for i, resource in enumerate(resources)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    run = encoder.begin_compute_pass()
    run.set_pipeline(pipeline)
    run.set_bind_group(0, group)
    run.dispatch_workgroups(len(padded) // 64)
    run.end()
    device.queue.submit([encoder.finish()])
    results = np.frombuffer(device.queue.read_buffer(outputs), np.float32)
    return results.reshape(-1, OUTPUTS)[: len(rows)]


def _wgpu_texture(device, texture: np.ndarray):
    import wgpu

    size = texture.shape[2::-1]
    use = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    made = device.create_texture(size=size, dimension="3d", format="rgba16float", usage=use)
    layout = {"bytes_per_row": 8 * size[0], "rows_per_image": size[1]}
    device.queue.write_texture({"texture": made}, texture.tobytes(), layout, size)
    return made


def translated(language: str, source: str, stage: str) -> str:
    """HLSL or Slang with an entry point `main` as WGSL."""
    options = ["-lang", language, "-target", "wgsl", "-entry", "main", "-stage", stage]
    with tempfile.TemporaryDirectory() as folder:
        path, result = Path(folder) / f"main.{language}", Path(folder) / "main.wgsl"
        path.write_text(source)
        done = subprocess.run([slangc(), path, *options, "-o", result], capture_output=True)
        assert done.returncode == 0, done.stderr.decode()
        return result.read_text()


def check_wgsl(compiler: str, source: str, folder: Path) -> None:
    """Whether a browser's compiler takes a file: Chromium has tint, Firefox naga."""
    path = shutil.which(compiler)
    if path is None:
        pytest.skip(f"{compiler} is not installed")
    file = folder / "shader.wgsl"
    file.write_text(source)
    options = ["--format", "wgsl"] if compiler == "tint" else []  # it writes SPIR-V otherwise
    done = subprocess.run([path, *options, file], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@cache
def gl_context():
    """An OpenGL context without a window; skips the test where there is none."""
    moderngl = pytest.importorskip("moderngl", reason="moderngl is not installed")
    try:
        context = moderngl.create_context(standalone=True, backend="egl", require=330)
    except Exception as error:
        pytest.skip(f"no OpenGL context: {error}")
    context.simple_framebuffer((1, 1)).use()  # without one, nothing is drawn
    return context


@cache
def wgpu_device():
    """A WebGPU device; skips the test where there is none."""
    wgpu = pytest.importorskip("wgpu", reason="wgpu is not installed")
    try:
        return wgpu.utils.get_default_device()
    except Exception as error:
        pytest.skip(f"no WebGPU device: {error}")


@cache
def slangc() -> str:
    """The path of Slang's compiler; skips the test where there is none."""
    path = os.environ.get("SLANGC") or shutil.which("slangc")
    if path is None or not Path(path).is_file():
        pytest.skip("Slang's compiler, slangc, is neither on the path nor named by SLANGC")
    return path
