"""A sheet blends materials down the rows and has a coat per column."""

import numpy as np
import pytest
from benchmarks.quality import sphere

import urushi

pytest.importorskip("matplotlib", reason="the extra 'eval' is not installed")
sheet = pytest.importorskip("figures.sheet")


@pytest.fixture
def materials():
    return [urushi.encode(urushi.diffuse(x)) for x in (0.1, 0.8, 0.3)]


def test_rows_pass_by_every_material_and_columns_are_coats(materials):
    coats = {"bare": None, "amber": sheet.COATS["amber"]}
    made = {(c.row, c.column): c.material for c in sheet.cells(materials, 5, coats)}
    assert sorted(made) == [(row, column) for row in range(5) for column in range(2)]
    assert [made[row, 0] for row in (0, 2, 4)] == materials
    assert made[1, 0] == urushi.lerp(materials[0], materials[1], 0.5)
    amber = dict(sheet.COATS["amber"])
    top = urushi.dielectric(amber.pop("alpha"), amber.pop("eta"))
    assert made[3, 1] == urushi.layer(top, urushi.lerp(*materials[1:], 0.5), **amber)


@pytest.mark.parametrize(("materials_", "rows"), [(2, 2), (2, 7), (3, 4), (4, 5), (5, 3)])
def test_steps_are_even(materials_, rows):
    positions = [k + t for k, t in sheet.steps(materials_, rows)]
    np.testing.assert_allclose(positions, np.linspace(0, materials_ - 1, rows))
    assert all(0 <= k < materials_ - 1 and 0 <= t <= 1 for k, t in sheet.steps(materials_, rows))


def test_labels():
    assert sheet.labels(["gold", "felt"], 3) == ["gold", "gold 50%\nfelt 50%", "felt"]


def test_every_coat_can_be_laid(materials):
    for cell in sheet.cells(materials[:2], 2, sheet.COATS):
        assert cell.material.channels == 3


def test_a_picture_is_written(tmp_path):
    pictures = np.full((2, 3, 8, 8, 3), 0.2)
    sheet.draw(tmp_path / "sheet.png", pictures, ["a", "b"], ["x", "y", "z"])
    assert (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_is_a_lit_sphere(small_spheres):
    material = urushi.encode(urushi.diffuse(0.5))
    picture = sphere.studio(material.f)
    inside = sphere.mask()
    assert (picture[inside].mean(axis=0) > 0).all()
    assert not picture[~inside].any()
