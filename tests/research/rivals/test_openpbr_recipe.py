"""The closed form of the recipe: limits in which it is known."""

import numpy as np
import pytest
from research.rivals import openpbr_recipe as recipe

from urushi.core import direction_sets
from urushi.core.quadrature import directional_albedos

LAMBERT = {"base_color": (0.6, 0.4, 0.2), "specular_weight": 0.0}


def test_a_coat_of_the_index_of_air_absorbs_only():
    """Nothing is reflected or refracted: Beer's law on the straight paths of both directions.

    The fit of the darkening's mean Fresnel term has 0.2 % at an index of one.
    """
    pairs = direction_sets.cosine_pairs(np.random.default_rng(5), 200, lowest_cosine=0.05)
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
    albedo = directional_albedos(lambda *pair: recipe.f(metal, *pair), wi)
    assert np.allclose(albedo, 1, atol=0.03)
