"""`urushi sheet` blends materials down the rows, has a coat per column, and refuses bad input."""

import numpy as np
import pytest

import urushi
from urushi.app import cli
from urushi.errors import ParameterError
from urushi.eval import sheet, sphere
from urushi.nets import weights
from urushi.nets.architecture import Architecture, init

pytestmark = pytest.mark.usefixtures("untrained")


@pytest.fixture
def materials(untrained):
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


def test_what_cannot_be_a_sheet(materials):
    strange = weights.Model.of(Architecture(), init(Architecture(), 9), {})
    other = urushi.encode(urushi.diffuse(0.5), strange)
    odd = urushi.encode(lambda wi, wo: np.ones((len(wi), 2)))
    bare = {"bare": None}
    for given, rows, coats, words in [
        (materials[:1], 2, bare, "give two or more"),
        (materials, 1, bare, "1 rows"),
        (materials, 2, {}, "no columns"),
        ([*materials, other], 4, bare, "different weights"),
        ([odd, odd], 2, bare, "2 channels"),
    ]:
        with pytest.raises(ParameterError, match=words):
            list(sheet.cells(given, rows, coats))


def test_the_command_writes_a_picture(tmp_path, capsys, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(sphere, "studio", lambda f: np.full((64, 64, 3), 0.2))
    file = tmp_path / "sheet.png"
    urushi.encode(urushi.diffuse(0.5)).save(tmp_path / "grey.safetensors")
    arguments = [str(tmp_path / "grey.safetensors"), "conductor(0.2, 0.9)", "--rows", "2"]
    assert cli.main(["sheet", *arguments, "--coats", "bare", "clear", "-o", str(file)]) == 0
    assert capsys.readouterr().out.strip() == str(file)
    assert file.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["diffuse(0.5)"], "give two or more"),
        (["diffuse(0.5)", "diffuse(0.2)", "--coats", "wax"], "no coat 'wax'; choose from bare, cl"),
        (["diffuse(0.5)", "diffuse(0.2)", "--coats", "bare", "bare"], "is named twice"),
        (["diffuse(0.5)", "absent.binary"], "there is no file 'absent.binary'"),
        (["diffuse(0.5)", "diffuse(0.2)", "--rows", "1"], "--rows is 1"),
        (["diffuse(0.5)", "strange-grey.safetensors"], "does not match the weights"),
    ],
)
def test_errors(arguments, sentence, tmp_path, capsys, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    strange = weights.save(tmp_path / "strange", Architecture(), init(Architecture(), 9), {})
    urushi.encode(urushi.diffuse(0.5), strange).save("strange-grey.safetensors")
    assert cli.main(["sheet", *arguments, "-o", "sheet.png"]) == 2
    message = capsys.readouterr().err
    assert sentence in message and message.count("\n") == 1
    assert not (tmp_path / "sheet.png").exists()


def test_a_picture_needs_its_suffix(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    output = str(tmp_path / "sheet.exr")
    assert cli.main(["sheet", "diffuse(0.5)", "diffuse(0.2)", "-o", output]) == 2
    assert "does not end in a picture format" in capsys.readouterr().err


def test_a_picture_is_a_lit_sphere(small_spheres):
    material = urushi.encode(urushi.diffuse(0.5))
    picture = sphere.studio(material.f)
    inside = sphere.mask()
    assert (picture[inside].mean(axis=0) > 0).all()
    assert not picture[~inside].any()
