"""The closed form of the recipe: limits in which it is known."""

import numpy as np
import pytest
from research.rivals import openpbr_recipe as recipe

from urushi.core import direction_sets
from urushi.core.quadrature import half_vector_rule
from urushi.errors import ParameterError

LAMBERT = {"base_color": (0.6, 0.4, 0.2), "specular_weight": 0.0}


@pytest.fixture(scope="module")
def pairs():
    return direction_sets.cosine_pairs(np.random.default_rng(5), 200, lowest_cosine=0.05)


@pytest.mark.parametrize("form", ["specification", "two_sided"])
def test_without_specular_reflection_the_bare_base_is_lambertian(pairs, form):
    expected = np.broadcast_to(np.array(LAMBERT["base_color"]) / np.pi, (200, 3))
    assert np.allclose(recipe.f(LAMBERT, *pairs, form), expected, atol=1e-6)


def test_materialx_scales_by_an_albedo_that_an_index_of_one_does_not_remove():
    """Its fit is of Schlick's term, which is 1 at grazing angles for every index."""
    dip = [np.array([[np.sqrt(1 - c * c), 0, c]]) for c in (0.2, 1.0)]
    f = [recipe.f(LAMBERT, i, dip[1])[0, 0] * np.pi / 0.6 for i in dip]
    assert f[0] < 0.9 < f[1] < 1


def test_a_coat_of_the_index_of_air_absorbs_only(pairs):
    """Nothing is reflected or refracted: Beer's law on the straight paths of both directions.

    The fit of the darkening's mean Fresnel term has 0.2 % at an index of one.
    """
    coat = {"coat_weight": 1.0, "coat_ior": 1.0, "coat_color": (0.9, 0.5, 0.25)}
    path = 0.5 / pairs[0][:, 2:] + 0.5 / pairs[1][:, 2:]
    exact = recipe.f(LAMBERT, *pairs, "two_sided") * np.array(coat["coat_color"]) ** path
    for form in ("specification", "two_sided"):
        assert np.allclose(recipe.f(LAMBERT | coat, *pairs, form), exact, rtol=5e-3)


@pytest.mark.parametrize("rough", [0.3, 0.6, 1.0])
def test_a_white_metal_reflects_all_light(rough):
    """Compensated for multiple scattering, within the error of MaterialX's fit."""
    metal = {"base_metalness": 1.0, "base_color": 1.0, "specular_roughness": rough}
    cosine = np.array([0.95, 0.7, 0.4])
    wi = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], -1)
    wo, weight = half_vector_rule(wi)
    for i, o, w in zip(wi, wo, weight, strict=True):
        f = recipe.f(metal, np.broadcast_to(i, o.shape), o)
        albedo = (f * (w * o[:, 2])[:, None]).sum(0)
        assert np.allclose(albedo, 1, atol=0.03)


def test_a_rough_coat_widens_the_lobe_of_the_base():
    """Under it the lobe has the roughness (r^4 + 2 c^4)^(1/4) of the specification."""
    metal = {"base_metalness": 1.0, "base_color": 1.0}
    coat = {"coat_weight": 1.0, "coat_ior": 1.0, "coat_roughness": 0.5}
    wide = (0.3**4 + 2 * 0.5**4) ** 0.25
    i, o = np.array([[0.0, 0.0, 1.0]]), np.array([[np.sin(0.4), 0.0, np.cos(0.4)]])
    under = recipe.f(metal | coat | {"specular_roughness": 0.3}, i, o, "two_sided")
    alone = recipe.f(metal | {"specular_roughness": wide}, i, o, "two_sided")
    assert np.allclose(under, alone, rtol=5e-3)  # the darkening, as above


def test_what_the_recipe_does_not_have_is_refused(pairs):
    with pytest.raises(ParameterError, match="fuzz_weight is 0.5; the recipe has base and coat"):
        recipe.f({"fuzz_weight": 0.5}, *pairs)
    with pytest.raises(ParameterError, match="no parameter 'coat_wieght'"):
        recipe.f({"coat_wieght": 0.5}, *pairs)
