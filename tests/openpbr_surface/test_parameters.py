"""The table of parameters, against the specification's reference graph and its examples."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.openpbr_surface.parameters import PARAMETERS, checked, complete


def test_every_parameter_of_the_examples_is_known(openpbr_examples):
    names = {
        element.get("name")
        for path in openpbr_examples.glob("*.mtlx")
        for surface in ElementTree.parse(path).getroot().iter("open_pbr_surface")
        for element in surface.iter("input")
    }
    assert names
    assert names <= PARAMETERS.keys()


def test_names_and_defaults_are_those_of_the_reference_graph():
    materialx = pytest.importorskip("MaterialX", reason="the package materialx is not installed")
    path = Path(materialx.__file__).parent / "libraries" / "bxdf" / "open_pbr_surface.mtlx"
    definition = ElementTree.parse(path).getroot().find("nodedef")
    assert definition.get("version") == "1.1.1"
    given = {element.get("name"): element.get("value") for element in definition.iter("input")}
    assert list(given) == list(PARAMETERS)
    for name, text in given.items():
        default = PARAMETERS[name].default
        if text in (None, "false"):
            assert not default
        else:
            assert np.array_equal(np.float64(text.split(",")), np.atleast_1d(default))


def test_defaults_lie_in_their_ranges():
    values = complete({})
    assert values.keys() == {name for name, p in PARAMETERS.items() if p.kind != "vector"}


def test_values_are_checked():
    assert checked("coat_weight", 0.25) == 0.25
    assert np.array_equal(checked("coat_color", 0.5), [0.5, 0.5, 0.5])
    assert not np.signbit(checked("coat_color", [-0.0, 1, 1])).any()
    with pytest.raises(ParameterError, match=r"x: coat_weight is 1.5; it must be in \[0, 1\]"):
        checked("coat_weight", 1.5, "x")
    with pytest.raises(ParameterError, match="specular_ior is -1; it must be 0 or more"):
        checked("specular_ior", -1)
    with pytest.raises(ParameterError, match="give a number$"):
        checked("coat_weight", [0.1, 0.2, 0.3])
    with pytest.raises(ParameterError, match="give a number or three, one per RGB channel"):
        checked("base_color", "red")
    with pytest.raises(ParameterError, match="coat_roughness is nan"):
        checked("coat_roughness", float("nan"))
