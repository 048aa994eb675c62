"""Materials with a table over directions, closer than any code."""

from dataclasses import replace

import numpy as np
import pytest
from tests.directions import above, at_cosines
from tests.material.conftest import error, two_lobes, velvet

from urushi.core.direction_sets import cosine_pairs
from urushi.core.quadrature import POLAR_NODES, directional_albedos
from urushi.core.table import SHAPE, interpolated
from urushi.errors import ParameterError
from urushi.material import Material, encode, layer
from urushi.material.albedo_rule import albedo_rule
from urushi.material.values import required_pairs
from urushi.nets.weights import anisotropic_model
from urushi.walk import conductor, dielectric, diffuse


def test_the_table_of_a_code_is_its_f(model):
    """Both are linear in ln f between nodes: rounding apart they are equal."""
    gold, amber = conductor(0.3, r0=(0.9, 0.6, 0.3)), encode(diffuse((0.5, 0.2, 0.05)), model)
    pairs = cosine_pairs(np.random.default_rng(1), 4000, lowest_cosine=0.05)
    wi, wo = (w.astype(np.float32) for w in pairs)
    for material in (
        amber,
        layer(dielectric(0.05, 1.5), amber),
        layer(dielectric(0.1, 1.5), encode(gold, model), sigma_t=(2, 0.5, 0.1), albedo=0.7),
        layer(dielectric(0.02, 1.3), encode(conductor(0.1, r0=0.9), model)),
        layer(dielectric(0.3, 1.2), encode(gold, model), sigma_t=0.3),
    ):
        f, networks = replace(material, table=None).f(wi, wo), material.model.networks
        top = networks.top(material.latents[:, None], wi, wo).T
        found = top + interpolated(networks.table(material.latents), wi, wo)
        np.testing.assert_allclose(found, f, rtol=1e-4)
    assert model.networks.table(encode(gold, model).latents) is None  # lobes alone need none


def test_functions_have_one_unless_their_code_is_exact(model, other_model):
    for exact in (conductor(0.2, 0.9), dielectric(0.1, 1.5), diffuse(0.5)):
        assert encode(exact, model).table is None
    wi, wo = cosine_pairs(np.random.default_rng(3), 4000, lowest_cosine=0.02)
    for weights in (model, other_model):  # of any weights
        # Within the linear interpolation of the narrow lobe
        assert error(encode(two_lobes, weights), two_lobes(wi, wo)[:, None], wi, wo) < 0.005
        assert encode(two_lobes, weights, table=False).table is None


def test_the_known_lobe_of_other_weights_lies_beside_it(material, other_model):
    """It is not interpolated, however narrow it is."""
    again, wi = encode(material, other_model), above(50, 1, 0.1)
    assert again.beside_lobe
    np.testing.assert_array_equal(again.latents[:, :6], material.latents[:, :6])
    mirrored = wi * np.float32([-1, -1, 1])
    np.testing.assert_allclose(again.f(wi, mirrored), material.f(wi, mirrored), rtol=0.01)


def test_about_as_much_light_as_the_source(model):
    wi = at_cosines(np.linspace(0.15, 1, 9))
    white = encode(lambda wi, wo: np.full(len(wi), 1 / np.pi), model, table=True)
    albedo = white.directional_albedo(wi)
    assert white.table is not None and albedo.min() > 0.95 and albedo.max() <= 1 + 1e-3
    shiny, rule = encode(lambda *w: velvet(*w)[:, 1], model, table=True), albedo_rule()
    source = rule.albedo(velvet(rule.wi, rule.wo)[:, 1])
    at = np.interp(wi[:, 2], rule.directions[::-1, 2], source[::-1])
    assert (shiny.directional_albedo(wi)[:, 0] <= at + 0.01).all()


@pytest.mark.parametrize("g", [-0.8, -0.9, -0.95])
def test_the_albedo_of_a_backward_peak_is_the_integral_of_f(model, g):
    medium = layer(dielectric(0.3, 1.0), encode(diffuse(0.3), model), sigma_t=2, albedo=1, g=g)
    wi = at_cosines(np.linspace(0.3, 1, 6))
    expected = directional_albedos(medium.f, wi, polar=8 * POLAR_NODES)
    np.testing.assert_allclose(medium.directional_albedo(wi), expected, atol=0.006)


def test_the_same_alone_and_among_many(tabulated, model):
    for channel in (0, 2):
        alone = encode(lambda *w, c=channel: velvet(*w)[:, c], model, table=True)
        np.testing.assert_array_equal(alone.table, tabulated.table[..., channel, None])


@pytest.mark.parametrize("wrong", [np.zeros((3, 7)), np.full((*SHAPE, 3), np.inf)])
def test_wrong_tables_and_those_of_two_widths_are_refused(wrong, tabulated, model):
    with pytest.raises(ParameterError, match="table"):
        Material(tabulated.latents, model, wrong)
    other = anisotropic_model()
    latents = np.zeros((1, other.arch.latent), np.float32)
    for make in (
        lambda: required_pairs(velvet, other, True),
        lambda: Material(latents, other, np.zeros((*SHAPE, 1))),
    ):
        with pytest.raises(ParameterError, match="cannot have tables"):
            make()
