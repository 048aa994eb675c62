"""The referee's pairs and mappings, reference values for other renderers, and formulas of coats."""

import csv
import json
import os
import stat
import sys

import numpy as np
import pytest
from benchmarks import conformance, experiment, layering_values
from benchmarks.experiments import coat_roughness, referee
from benchmarks.measures import channel_errors
from benchmarks.referee import materials, methods

import urushi
from urushi.errors import ParameterError
from urushi.walk.simulate import albedo


def test_forty_materials_and_pairs_of_few_angles():
    wi, wo = materials.pairs()
    assert len(materials.STACKS) == 40
    assert wi.shape == wo.shape == (materials.ANGLES * materials.EACH, 3)
    np.testing.assert_allclose((wi**2).sum(1), 1, atol=1e-6)
    np.testing.assert_allclose((wo**2).sum(1), 1, atol=1e-6)
    between = (wi.astype(float) * wo).sum(1).reshape(materials.ANGLES, materials.EACH)
    np.testing.assert_allclose(between - between[:, :1], 0, atol=1e-6)
    # Cosine density has a mean cosine of 2/3 and a mean square of 1/2.
    for w in (wi, wo):
        assert abs(w[:, 2].mean() - 2 / 3) < 0.03 and abs((w[:, 2] ** 2).mean() - 1 / 2) < 0.04


PROGRAM = """#!{python}
import sys, numpy as np
pairs = np.frombuffer(sys.stdin.buffer.read(), "<f4").reshape(-1, 6)
given = dict(text.split("=") for text in sys.argv[1:])
color = np.array(given["base_color"].split(","), "<f4")
sys.stdout.buffer.write((pairs[:, 5:] * color).astype("<f4").tobytes())
"""


def test_a_program_reads_parameters_and_pairs(tmp_path, monkeypatch):
    monkeypatch.delenv(methods.PROGRAM, raising=False)
    stack, (wi, wo) = materials.STACKS["car paint, solid red"], materials.pairs()
    with pytest.raises(FileNotFoundError):
        methods.program(stack, 1, wi, wo)
    assert "missing" in referee.measure("adobe/openpbr-bsdf", experiment.Options(share=0.03))
    program = tmp_path / "program"
    program.write_text(PROGRAM.format(python=sys.executable))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv(methods.PROGRAM, str(program))
    expected = wo[:, 2:] * np.float32([0.6, 0.03, 0.03])
    np.testing.assert_allclose(methods.program(stack, 1, wi, wo), expected, rtol=1e-5)
    with pytest.raises(ParameterError):  # the pearl has two coats
        methods.program(materials.STACKS["car paint, pearl"], 1, wi, wo)


def test_a_paint_is_the_same_by_tables_and_by_roughplastic(rgb):
    """Both have the closed form of a coat over a Lambertian surface, within 2 %."""
    stack = materials.STACKS["car paint, solid red"]
    wi, wo = materials.pairs()
    named = ("Urushi, tables", "Mitsuba's `roughplastic`")
    first, second = (methods.METHODS[name].f(stack, 1, wi, wo) for name in named)
    assert channel_errors(first, second, wi, wo).max() < 0.02


def test_reference_values_agree_with_the_walk():
    """Values by other random numbers are within 4.5 standard errors."""
    stored = json.loads(layering_values.FILE.read_text())
    pairs, lit = layering_values.directions()
    for name, w in zip(("wi", "wo", "lit"), (*pairs, lit), strict=True):
        np.testing.assert_allclose(stored[name], w, atol=1e-7)
    assert list(stored["stacks"]) == list(layering_values.STACKS)
    for name, stack in layering_values.STACKS.items():
        own, described = stored["stacks"][name], layering_values.described(stack)
        assert {k: own[k] for k in described} == described
        values = (
            ("f", urushi.simulate(stack, *pairs, walks=1 << 14, seed=3, progress=False)),
            ("albedo", albedo(stack, lit, walks=1 << 14, seed=3)),
        )
        for kind, (found, se) in values:
            known, error = np.array(own[kind]), np.array(own[f"{kind}_se"])
            allowed = 4.5 * np.hypot(se, error) + 1e-4 * known + 1e-6
            assert (np.abs(found - known) < allowed).all(), (name, kind)


def test_formulas_of_coats_have_their_limits():
    own, r = coat_roughness.FORMULAS, np.linspace(0.1, 1, 7)
    for rule in (own.base_roughness, own.base_roughness_inside):
        np.testing.assert_allclose(rule(1.0, 0.7, r), r)  # a coat of index 1 does nothing
        assert (np.diff(rule(1.5, 0.4, r)) > 0).all() and (np.diff(rule(1.5, r, 0.2)) > 0).all()
    np.testing.assert_allclose(own.base_roughness(1.5, 0.0, 0.05), 0.05 * 1.5**0.795, rtol=1e-2)
    assert own.internal_reflection(1.5, 0.0) == pytest.approx(0.04)
    assert own.darkening(0.6, 1.0) == 1 and own.darkening(0.0, 0.3) == 1


def test_the_table_of_coats_is_that_of_the_results_and_the_formulas_fit_it():
    stored = experiment.stored("coat_roughness")
    with (coat_roughness.DOCS / "coat_roughness.csv").open() as file:
        head, *rows = csv.reader(file)
    assert head == list(coat_roughness.COLUMNS)
    expected = [coat_roughness.line(row) for row in coat_roughness.metals(stored["cases"])]
    numbers = np.array(rows, float)
    np.testing.assert_allclose(numbers, expected)
    eta, coat, base = numbers[:, :3].T
    own = coat_roughness.FORMULAS
    rules = {"outside": own.base_roughness, "inside": own.base_roughness_inside}
    # The fits' stated errors: 0.02 and 0.03 rms.
    for name, column, limit in (("outside", 3, 0.021), ("inside", 7, 0.03)):
        off = rules[name](eta, coat, base) - numbers[:, column]
        assert np.sqrt((off**2).mean()) < limit
    for name, constants in coat_roughness.fit(stored["cases"]).items():
        rule = (rules | {"internal": own.internal_reflection})[name]
        assert rule.__defaults__[-len(constants) :] == pytest.approx(constants, abs=0.006)


@pytest.mark.skipif(not os.environ.get(methods.BPY), reason="BPY_PYTHON names no Python with bpy")
def test_tiles_of_cycles_show_the_brdf():
    """A Lambertian surface under a coat of index 1 and a tint of 1 is itself."""
    stack = urushi.coat(urushi.diffuse((0.5, 0.4, 0.3)), 0.1, 1.0)
    f, white = np.split(methods.in_blender((stack,))[stack], [-3])
    np.testing.assert_allclose(f * np.pi, np.tile((0.5, 0.4, 0.3), (len(f), 1)), atol=1e-3)
    np.testing.assert_allclose(white, np.tile((0.5, 0.4, 0.3), (3, 1)), atol=1e-3)


def test_wrong_values_are_refused():
    _, reference = conformance.read()
    with pytest.raises(ParameterError, match="give one of \\(40, 300, 3\\)"):
        conformance.errors(reference["f"][:3], reference)
    with pytest.raises(ParameterError, match="must be finite"):
        conformance.errors(np.full_like(reference["f"], np.nan), reference)


def test_values_of_another_renderer_are_compared(tmp_path, capsys):
    """All 25 % too bright: every line has an E and an albedo's error of 25 %."""
    path = tmp_path / "mine.npz"
    np.savez(path, f=1.25 * conformance.read()[1]["f"])
    conformance.main(path)
    lines = capsys.readouterr().out.splitlines()
    assert " mine " in lines[0] and len(lines) == 2 + 40 + 2
    assert all("| 25.00 / +25.0 |" in line for line in lines[2:42])
