"""The library of materials: every description is read, conserves energy, and is named."""

import numpy as np
import pytest

import urushi
from urushi.app import cli
from urushi.app.describe import describe, is_description, library
from urushi.walk import analytic
from urushi.walk.simulate import albedo

WI = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.96, 0.28]])


@pytest.mark.parametrize("name", library())
def test_materials_reflect_no_more_light_than_there_is(name):
    """The standard error of an albedo is about 0.01."""
    material = describe(name)
    if not isinstance(material, urushi.Stack):
        f = analytic.f(material, WI, WI * [-1, -1, 1])
        assert (f > 0).all() and np.isfinite(f).all()
        return
    found, error = albedo(material, WI, walks=2048, seed=0)
    assert (found > 0).all()
    assert (found < 1 + 4 * error).all()


def test_names_stand_for_descriptions(capsys):
    assert len(library()) == 24
    assert is_description("black urushi") and not is_description("grey urushi")
    assert describe("tenmoku") == describe(library()["tenmoku"])
    assert cli.main(["materials"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in library())


def test_hues_are_those_of_the_names():
    """Diffuse light: the strongest channel of red, green and blue materials."""
    for name, strongest in (
        ("vermilion urushi", 0),
        ("metallic red car paint", 0),
        ("candy blue car paint", 2),
        ("green enamel on silver", 1),
        ("celadon", 1),
        ("anodised aluminium", 2),
    ):
        found, _ = albedo(describe(name), WI[1:2], walks=4096, seed=0)
        assert found[0].argmax() == strongest, name
