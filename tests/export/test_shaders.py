"""Exported files, run in their languages, agree with `Material`."""

import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from tests.export import gpu

from urushi.app.cli import main
from urushi.core.table import SHAPE
from urushi.errors import ParameterError, UrushiWarning
from urushi.export import networks
from urushi.export.program import codes_text, template_text
from urushi.material import Material

#: Relative difference of f and pdf: some roundings of single precision, in ln f up to 25.
TOLERANCE = 1e-5

#: The density at a drawn direction changes with the direction's last digits, the more the
#: narrower the lobe.
DRAWN_TOLERANCE = 1e-3

#: f with wi and wo exchanged: the same bits, except where compilers may reorder a product.
EXCHANGE_TOLERANCE = {"python": 0.0} | dict.fromkeys(("glsl", "wgsl", "hlsl", "slang"), 1e-6)

SHADERS = ("glsl", "wgsl", "hlsl", "slang")
KINDS = ("three lobes", "one lobe", "no lobe", "grey")
DIRECTIONS = np.s_[:, :3], np.s_[:, 4:7], np.s_[:, 8:11]


def module(text: str) -> ModuleType:
    """The Python module of an exported file."""
    result = ModuleType("exported")
    exec(text, result.__dict__)
    return result


def run_python(text: str, rows: np.ndarray, codes: np.ndarray | None = None) -> np.ndarray:
    """As `gpu.run`."""
    exported = module(text)
    first = () if codes is None else (exported.prepare(codes[:, None]),)
    if hasattr(exported, "material"):  # a filled template
        first = (exported.material(),)
    wi, wo, u = (rows[columns] for columns in DIRECTIONS)
    direction, density = exported.sample(*first, wi, u)
    pdf = exported.pdf(*first, wi, wo)
    return np.column_stack([exported.f(*first, wi, wo), pdf, direction, density])


def run(language: str, text: str, rows: np.ndarray, codes: np.ndarray | None = None) -> np.ndarray:
    return (
        run_python(text, rows, codes)
        if language == "python"
        else gpu.run(language, text, rows, codes)
    )


def close(value: np.ndarray, expected: np.ndarray, tolerance: float) -> bool:
    """Whether values agree to a relative tolerance, zeros exactly."""
    return bool((np.abs(value - expected) <= tolerance * np.abs(expected)).all())


def check(
    language: str,
    text: str,
    material: Material,
    rows: np.ndarray,
    codes=None,
    tolerance: float = TOLERANCE,
) -> None:
    """Whether a file evaluates and samples a material as `Material` does, and is reciprocal."""
    wi, wo, u = (rows[columns] for columns in DIRECTIONS)
    result = run(language, text, rows, codes)
    f, pdf, direction, density = np.split(result, (3, 4, 7), axis=1)
    assert close(f, material.f(wi, wo), tolerance)
    assert (f[(wi[:, 2] <= 0) | (wo[:, 2] <= 0)] == 0).all()
    assert close(pdf[:, 0], material.pdf(wi, wo), tolerance)
    assert np.abs(direction - material.sample(wi, u)[0]).max() < 1e-4
    assert close(density[:, 0], material.pdf(wi, direction), DRAWN_TOLERANCE)
    swapped = rows.copy()
    swapped[:, :3], swapped[:, 4:7] = wo, wi
    assert close(run(language, text, swapped, codes)[:, :3], f, EXCHANGE_TOLERANCE[language])


@pytest.mark.parametrize("kind", KINDS)
def test_material_in_python(materials, rows, kind):
    check("python", materials[kind].shader("python"), materials[kind], rows)


@pytest.mark.parametrize("kind", ["three lobes", "grey"])
@pytest.mark.parametrize("language", SHADERS)
def test_material_in_shaders(materials, rows, language, kind):
    check(language, materials[kind].shader(language), materials[kind], rows)


@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_codes_as_arguments(model, materials, rows, language):
    material = materials["three lobes"]
    check(language, codes_text(language, model, "urushi"), material, rows, material.latents.T)


@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_templates_with_codes_filled_in(model, materials, rows, language):
    material = materials["three lobes"]
    text = template_text(language, model)
    for i, numbers in enumerate(material.latents.T):
        for channel, number in zip(("red", "green", "blue"), numbers, strict=True):
            text, count = re.subn(rf"\bcode_{i}_{channel}\b", f"{float(number)!r}", text)
            assert count == 1
    check(language, text, material, rows)


@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_loops_over_tables(materials, rows, language, monkeypatch):
    """Layers that are too large to unroll are loops; here the second hidden one is."""
    monkeypatch.setattr(networks, "UNROLLED", 200)
    text = materials["one lobe"].shader(language)
    assert text.count("for ") >= 1
    check(language, text, materials["one lobe"], rows)


@pytest.mark.parametrize("kind", ["three lobes", "no lobe"])
def test_sampling_chi_squared(materials, sphere_test, kind):
    exported = module(materials[kind].shader("python"))
    wi = np.array([[0.6, 0.0, 0.8]], np.float32)
    u = np.random.default_rng(1).random((100_000, 3), np.float32)
    drawn, _ = exported.sample(wi.repeat(len(u), axis=0), u)
    assert sphere_test(drawn, lambda wo: exported.pdf(wi, wo)) > 1e-3


def test_a_table_is_left_out_with_a_warning(model, materials):
    codes = materials["grey"]
    tabulated = Material(codes.latents, model, None, np.zeros((*SHAPE, 1), np.float16))
    with pytest.warns(UrushiWarning, match="table"):
        assert tabulated.shader("glsl") == codes.shader("glsl")


def test_prefixes_allow_several_materials_in_one_shader(materials, rows):
    material = materials["one lobe"]
    other = materials["three lobes"].shader("glsl", "car_paint")
    assert "car_paint_f(" in other and "CarPaintSample" in other and "urushi_" not in other
    check("glsl", other + material.shader("glsl"), material, rows)


@pytest.mark.parametrize("compiler", ["tint", "naga"])
def test_wgsl_is_valid_for_browsers(model, materials, tmp_path, compiler):
    """By the compilers of Chromium and of Firefox."""
    path = shutil.which(compiler)
    if path is None:
        pytest.skip(f"{compiler} is not installed")
    end = "\n@fragment fn main() -> @location(0) vec4f { return vec4f(1.0); }\n"
    for text in (materials["three lobes"].shader("wgsl"), codes_text("wgsl", model, "urushi")):
        file = tmp_path / "material.wgsl"
        file.write_text(text + end)
        options = ["--format", "wgsl"] if compiler == "tint" else []  # it writes SPIR-V otherwise
        done = subprocess.run([path, *options, file], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_command_writes_the_file(model, materials, tmp_path, capsys):
    from urushi.nets import weights

    networks, stored = tmp_path / "weights.safetensors", tmp_path / "material.safetensors"
    weights.save(networks, model.arch, model.params, {})
    materials["one lobe"].save(stored)
    given = ["-l", "wgsl", "--weights", str(networks), "-o", str(tmp_path / "material.wgsl")]
    assert main(["export", str(stored), *given]) == 0
    written = Path(capsys.readouterr().out.strip())
    assert written.read_text() == materials["one lobe"].shader("wgsl")
    assert main(["export", *given, "--prefix", "paint"]) == 0
    assert written.read_text() == codes_text("wgsl", model, "paint")


def test_example_of_the_page(materials):
    page = (Path(__file__).parents[2] / "docs" / "export.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    exec(block, {"coated": materials["three lobes"]})


def test_errors_name_the_cure(model, materials):
    material = materials["one lobe"]
    with pytest.raises(ParameterError, match="there is no language 'cg'; choose one of glsl, "):
        material.shader("cg")
    with pytest.raises(ParameterError, match="'a b' is not a valid prefix of function names"):
        material.shader("glsl", "a b")
    two = Material(material.latents[:2], model)
    with pytest.raises(ParameterError, match="has 2 channels; only materials of one or three"):
        two.shader("glsl")
