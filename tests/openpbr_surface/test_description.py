"""`urushi.openpbr`: the table of parameters, and descriptions in scenes, values and files."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from tests.directions import pairs_above
from tests.openpbr_surface.probes import error, loaded

import urushi
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.openpbr_surface.parameters import PARAMETERS, checked

pytestmark = pytest.mark.usefixtures("rgb")

LACQUER = dict(
    base_color=(0.6, 0.1, 0.05), coat_weight=1.0, coat_color=(0.9, 0.7, 0.4), coat_roughness=0.2
)


@pytest.mark.slow
def test_values_are_those_of_the_plugin():
    wi, wo = pairs_above(100, 0, 0.1)
    plugin = probing.bsdf_values(loaded(**LACQUER), wi, wo, np.full((100, 2), 0.5))
    assert np.array_equal(urushi.openpbr(**LACQUER).f(wi, wo), plugin)


def test_walks_average_the_reference():
    """The mean of 64 evaluations is that of two halves, whose random numbers differ."""
    wi, wo = pairs_above(100, 0, 0.1)
    walked = urushi.openpbr(reference=True, energy_compensation=False, **LACQUER)
    assert not np.array_equal(walked.f(wi, wo), walked.f(wi, wo, walks=2))
    many, few = walked.f(wi, wo, walks=64), walked.f(wi, wo, walks=8)
    assert abs(few.mean() / many.mean() - 1) < 0.1  # noise of some 3 %


def test_a_saved_material_is_read_as_it_was(tmp_path):
    saved = urushi.openpbr(**LACQUER, geometry_thin_walled=False)
    saved.save(tmp_path / "lacquer.mtlx", name="Lacquer")
    read = urushi.load_materialx(tmp_path / "lacquer.mtlx", "Lacquer")
    assert read.pop("type") == "openpbr"
    assert urushi.openpbr(**read) == urushi.openpbr(**LACQUER, geometry_thin_walled=False)


def test_a_uniform_material_is_encoded_and_textures_are_kept_or_refused(tmp_path):
    wi, wo = pairs_above(100, 0, 0.1)
    bare = urushi.openpbr(base_color=(0.6, 0.1, 0.05), specular_roughness=0.5)
    assert error(urushi.encode(bare).f(wi, wo), bare.f(wi, wo), wi, wo) < 0.05
    checker = {"type": "checkerboard"}
    textured = urushi.openpbr(base_color=checker)
    assert textured.textures == ["base_color"]
    assert textured.description()["base_color"] is checker
    assert mi.load_dict(textured.description()) is not None
    with pytest.raises(ParameterError, match="base_color is a texture, but a saved material"):
        textured.save(tmp_path / "x.mtlx")
    with pytest.raises(ParameterError, match="openpbr: base_color is a texture, but an encoded"):
        urushi.encode(textured)


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


def test_values_are_converted():
    assert checked("coat_weight", 0.25) == 0.25
    assert np.array_equal(checked("coat_color", 0.5), [0.5, 0.5, 0.5])
    assert not np.signbit(checked("coat_color", [-0.0, 1, 1])).any()
    given = urushi.openpbr(base_color=mi.ScalarColor3f(0.5, 0.25, 1), geometry_thin_walled=np.True_)
    assert given == urushi.openpbr(base_color=(0.5, 0.25, 1), geometry_thin_walled=True)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("coat_roughnes", 0.1, "did you mean coat_roughness"),
        ("coat_weight", 1.5, r"openpbr: coat_weight is 1.5; it must be in \[0, 1\]"),
        ("specular_ior", -1, "specular_ior is -1; it must be finite and 0 or more"),
        ("specular_ior", float("inf"), "specular_ior is inf; it must be finite"),
        ("coat_weight", [0.1, 0.2, 0.3], "give a number$"),
        ("base_color", np.full(3, 0.5 + 1j), "give a number or three, one per RGB channel"),
        ("base_color", "red", "give a number or three, one per RGB channel"),
        ("coat_roughness", float("nan"), "coat_roughness is nan"),
        ("base_color", {"type": "rgb"}, r"base_color is nan; it must be in \[0, 1\]"),
        ("geometry_thin_walled", {"type": "checkerboard"}, "thin_walled cannot be a texture"),
        ("geometry_thin_walled", np.array([0, 1]), "give true or false$"),
    ],
)
def test_wrong_parameters_are_refused_at_once(name, value, sentence):
    with pytest.raises(ParameterError, match=sentence):
        urushi.openpbr(**{name: value})
