"""Materials with a table: closer than any code, and still BRDFs."""

import numpy as np
import pytest
from tests.material.conftest import velvet

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.core.table import SHAPE
from urushi.errors import ParameterError
from urushi.material import Material, encode
from urushi.material.albedo_rule import albedo_rule
from urushi.material.values import required_pairs
from urushi.nets import lobe as lobes
from urushi.nets.weights import anisotropic_model
from urushi.walk import conductor, dielectric, diffuse


def two_lobes(wi, wo):
    """A narrow and a wide lobe of metals over a diffuse term."""
    lobe = np.float32([[0.02, 0.2, 1, 0, 1.5, 0], [0.15, 0.5, 1, 0, 1.5, 0]])
    return lobes.f(lobe, wi[:, None], wo[:, None]).sum(axis=1) + 0.05


def test_functions_have_one_unless_their_code_is_exact(model, other_model):
    for exact in (conductor(0.2, 0.9), dielectric(0.1, 1.5), diffuse(0.5)):
        assert encode(exact, model).table is None
    for weights in (model, other_model):  # of any weights
        material = encode(two_lobes, weights)
        wi, wo = cosine_pairs(np.random.default_rng(3), 4000, lowest_cosine=0.02)
        found = stack_error(material.f(wi, wo).T, two_lobes(wi, wo)[None], wi[:, 2], wo[:, 2])
        assert found < 0.005  # linear interpolation of the narrow lobe
        assert encode(two_lobes, weights, table=False).table is None


def test_the_known_lobe_of_other_weights_lies_beside_it(material, other_model, random_directions):
    """It is not interpolated, however narrow it is."""
    again, wi = encode(material, other_model), random_directions(50, 1, 0.1)
    assert again.beside_lobe
    np.testing.assert_array_equal(again.latents[:, :6], material.latents[:, :6])
    mirrored = wi * np.float32([-1, -1, 1])
    np.testing.assert_allclose(again.f(wi, mirrored), material.f(wi, mirrored), rtol=0.01)


def test_about_as_much_light_as_the_source(model):
    cosines = np.linspace(0.15, 1, 9)
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=1).astype(np.float32)
    white = encode(lambda wi, wo: np.full(len(wi), 1 / np.pi), model, table=True)
    assert white.table is not None
    assert white.directional_albedo(wi).max() <= 1 + 1e-3
    assert white.directional_albedo(wi).min() > 0.95
    shiny = encode(lambda *w: velvet(*w)[:, 1], model, table=True)
    rule = albedo_rule()
    source = rule.albedo(velvet(rule.wi, rule.wo)[:, 1])
    at = np.interp(cosines, rule.directions[::-1, 2], source[::-1])
    assert (shiny.directional_albedo(wi)[:, 0] <= at + 0.01).all()


@pytest.mark.parametrize("wrong", [np.zeros((3, 7)), np.full((*SHAPE, 3), np.inf)])
def test_wrong_tables_are_refused(wrong, tabulated, model):
    with pytest.raises(ParameterError, match="table"):
        Material(tabulated.latents, model, wrong)


def test_the_same_alone_and_among_many(tabulated, model):
    for channel in (0, 2):
        alone = encode(lambda *w, c=channel: velvet(*w)[:, c], model, table=True)
        np.testing.assert_array_equal(alone.table, tabulated.table[..., channel, None])


def test_networks_of_two_widths_have_none():
    other = anisotropic_model()
    with pytest.raises(ParameterError, match="cannot have tables"):
        required_pairs(velvet, other, True)
    latents = np.zeros((1, other.arch.latent), np.float32)
    with pytest.raises(ParameterError, match="cannot have tables"):
        Material(latents, other, np.zeros((*SHAPE, 1)))
