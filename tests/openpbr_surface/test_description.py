"""`urushi.openpbr`: a description that is the plugin's material, in scenes, values and files."""

import mitsuba as mi
import numpy as np
import pytest
from tests.directions import pairs_above
from tests.openpbr_surface.probes import error, loaded

import urushi
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing

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


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"coat_roughnes": 0.1}, "did you mean coat_roughness"),
        ({"coat_weight": 2}, r"coat_weight is 2; it must be in \[0, 1\]"),
        ({"geometry_thin_walled": {"type": "checkerboard"}}, "thin_walled cannot be a texture"),
    ],
)
def test_wrong_parameters_are_refused_at_once(parameters, sentence):
    with pytest.raises(ParameterError, match=sentence):
        urushi.openpbr(**parameters)
