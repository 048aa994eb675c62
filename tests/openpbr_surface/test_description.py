"""`urushi.openpbr`: a description that is the plugin's material, in scenes, values and files."""

import mitsuba as mi
import numpy as np
import pytest
from tests.directions import pairs_above

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
    described = {
        "type": "openpbr",
        "coat_weight": 1.0,
        "coat_roughness": 0.2,
        "base_color": {"type": "rgb", "value": [0.6, 0.1, 0.05]},
        "coat_color": {"type": "rgb", "value": [0.9, 0.7, 0.4]},
    }
    plugin = probing.bsdf_values(mi.load_dict(described), wi, wo, np.full((100, 2), 0.5))
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


def test_a_uniform_material_is_encoded():
    wi, wo = pairs_above(100, 0, 0.1)
    bare = urushi.openpbr(base_color=(0.6, 0.1, 0.05), specular_roughness=0.5)
    found, expected = urushi.encode(bare).f(wi, wo), bare.f(wi, wo)
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    assert (np.abs(found - expected) * weight).sum() < 0.05 * (expected * weight).sum()


def test_textures_are_kept_and_refused_where_one_value_is_needed(tmp_path):
    checker = {"type": "checkerboard"}
    textured = urushi.openpbr(base_color=checker)
    assert textured.textures == ["base_color"]
    assert textured.description()["base_color"] is checker
    assert mi.load_dict(textured.description()) is not None
    with pytest.raises(ParameterError, match="base_color is a texture, but a saved material"):
        textured.save(tmp_path / "x.mtlx")
    with pytest.raises(ParameterError, match="openpbr: base_color is a texture, but an encoded"):
        urushi.encode(textured)


def test_wrong_parameters_are_refused_at_once():
    with pytest.raises(ParameterError, match="did you mean coat_roughness"):
        urushi.openpbr(coat_roughnes=0.1)
    with pytest.raises(ParameterError, match=r"coat_weight is 2; it must be in \[0, 1\]"):
        urushi.openpbr(coat_weight=2)
    with pytest.raises(ParameterError, match="geometry_thin_walled cannot be a texture"):
        urushi.openpbr(geometry_thin_walled={"type": "checkerboard"})
