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
in vec3 wi; in vec3 wo; in vec3 u;
out vec3 f; out float pdf; out vec3 direction; out float density;
void main() {{
    {prepare}
    f = urushi_f({first}wi, wo);
    pdf = urushi_pdf({first}wi, wo);
    UrushiSample drawn = urushi_sample({first}wi, u);
    direction = drawn.direction;
    density = drawn.density;
}}
"""

WGSL_MAIN = """
@group(0) @binding(0) var<storage, read> rows: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4f>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{
    let wi = rows[3 * id.x].xyz; let wo = rows[3 * id.x + 1].xyz; let u = rows[3 * id.x + 2].xyz;
    {prepare}
    let drawn = urushi_sample({first}wi, u);
    results[2 * id.x] = vec4f(urushi_f({first}wi, wo), urushi_pdf({first}wi, wo));
    results[2 * id.x + 1] = vec4f(drawn.direction, drawn.density);
}}
"""

HLSL_MAIN = """
StructuredBuffer<float4> rows : register(t0);
RWStructuredBuffer<float4> results : register(u1);
[shader("compute")] [numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {{
    float3 wi = rows[3 * id.x].xyz, wo = rows[3 * id.x + 1].xyz, u = rows[3 * id.x + 2].xyz;
    {prepare}
    UrushiSample drawn = urushi_sample({first}wi, u);
    results[2 * id.x] = float4(urushi_f({first}wi, wo), urushi_pdf({first}wi, wo));
    results[2 * id.x + 1] = float4(drawn.direction, drawn.density);
}}
"""


def run(language: str, text: str, rows: np.ndarray, codes: np.ndarray | None = None) -> np.ndarray:
    """The `OUTPUTS` of a shader at rows (N, `INPUTS`); codes (size, 3): for a file of all."""
    runner = {"glsl": _run_glsl, "wgsl": _run_wgsl}.get(language, _run_slang)
    return runner(language, text, rows, codes)


def _main(template: str, text: str, codes: np.ndarray | None, three: str, kind: str, end: str):
    """The file with its entry point; the codes are literals in it."""
    if codes is None and "urushi_material()" in text:  # a filled template
        declared = "let" if three == "vec3f" else "UrushiMaterial"
        prepare = f"{declared} material = urushi_material();"
        return text + template.format(prepare=prepare, first="material, ")
    if codes is None:
        return text + template.format(prepare="", first="")
    numbers = ", ".join(f"{three}({r!r}, {g!r}, {b!r})" for r, g, b in codes.tolist())
    prepare = f"{kind}{numbers}{end}"
    return text + template.format(prepare=prepare, first="material, ")


def _run_glsl(language: str, text: str, rows: np.ndarray, codes: np.ndarray | None) -> np.ndarray:
    context = gl_context()
    count = 0 if codes is None else len(codes)
    start = f"UrushiMaterial material = urushi_prepare(vec3[{count}]("
    source = "#version 330\n" + _main(GLSL_MAIN, text, codes, "vec3", start, "));")
    varyings = ["f", "pdf", "direction", "density"]
    with context:  # WebGPU has contexts of its own
        program = context.program(vertex_shader=source, varyings=varyings)
        inputs = context.buffer(np.ascontiguousarray(rows, np.float32))
        outputs = context.buffer(reserve=4 * OUTPUTS * len(rows))
        layout = [(inputs, "3f 1x4 3f 1x4 3f 1x4", "wi", "wo", "u")]
        context.vertex_array(program, layout).transform(outputs, mode=context.POINTS)
        return np.frombuffer(outputs.read(), np.float32).reshape(-1, OUTPUTS)


def _run_wgsl(language: str, text: str, rows: np.ndarray, codes: np.ndarray | None) -> np.ndarray:
    count = 0 if codes is None else len(codes)
    start = f"let material = urushi_prepare(array<vec3f, {count}>("
    return _computed(_main(WGSL_MAIN, text, codes, "vec3f", start, "));"), rows)


def _run_slang(language: str, text: str, rows: np.ndarray, codes: np.ndarray | None) -> np.ndarray:
    compiler = slangc()
    wgpu_device()
    count = 0 if codes is None else len(codes)
    start = f"float3 codes[{count}] = {{"
    end = "}; UrushiMaterial material = urushi_prepare(codes);"
    source = _main(HLSL_MAIN, text, codes, "float3", start, end)
    options = ["-lang", language, "-target", "wgsl", "-entry", "main", "-stage", "compute"]
    with tempfile.TemporaryDirectory() as folder:
        path, result = Path(folder) / f"main.{language}", Path(folder) / "main.wgsl"
        path.write_text(source)
        done = subprocess.run([compiler, path, *options, "-o", result], capture_output=True)
        assert done.returncode == 0, done.stderr.decode()
        return _computed(result.read_text(), rows)


def _computed(source: str, rows: np.ndarray) -> np.ndarray:
    """The results of a compute shader in WGSL."""
    import wgpu
    from wgpu.utils.compute import compute_with_buffers

    del wgpu
    wgpu_device()
    groups = -(-len(rows) // 64)
    padded = np.zeros((64 * groups, INPUTS), np.float32)
    padded[:, 2] = 1.0
    padded[: len(rows)] = rows
    size = 4 * OUTPUTS * len(padded)
    out = compute_with_buffers(
        input_arrays={0: padded}, output_arrays={1: size}, shader=source, n=groups
    )
    return np.frombuffer(out[1], np.float32).reshape(-1, OUTPUTS)[: len(rows)]


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
