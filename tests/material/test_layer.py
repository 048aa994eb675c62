"""Coating and blending in the latent space: shapes, channels, identities, bad input."""

import numpy as np
import pytest
from tests.directions import at_cosines

from urushi.errors import ParameterError, UrushiWarning
from urushi.material import Material, encode, layer, lerp
from urushi.walk import conductor, dielectric, diffuse

TOP, GOLD = dielectric(0.1, 1.5), conductor(0.2, (0.98, 0.77, 0.34))
SATIN = dielectric(alpha_u=0.3, alpha_v=0.1, ior=1.5)
RATIO = r"alpha_u and alpha_v have a ratio of (100|30)"


def codes(channels: int, material: Material) -> Material:
    """A material of equal numbers, of the same weights."""
    return Material(np.ones((channels, 14)), material.model)


def test_an_empty_medium_has_no_albedo_and_no_g(material):
    clear = layer(TOP, material, sigma_t=0)
    assert clear == layer(TOP, material, albedo=0.9, sigma_t=0, g=0.8)
    assert clear != layer(TOP, material, albedo=0.9, sigma_t=0.1)


def test_coats_nest_and_encodable_bottoms_are_encoded(model):
    once = layer(TOP, GOLD, albedo=0.8, sigma_t=1, weights=model)
    assert once == layer(TOP, encode(GOLD, model), albedo=0.8, sigma_t=1)
    assert layer(TOP, once).channels == 3


def test_one_channel_grows_to_three(material):
    grey = codes(1, material)
    medium = {"sigma_t": 1, "fast": True}
    assert layer(TOP, grey, albedo=0.5, **medium).channels == 1
    assert layer(TOP, grey, albedo=(0.1, 0.5, 0.9), **medium).channels == 3
    assert layer(TOP, codes(5, material), albedo=0.5, **medium).channels == 5
    assert lerp(material, grey, 0.5).channels == 3


WRONG = [("albedo", 1.1), ("sigma_t", -1), ("g", 1), ("albedo", (0.1, 0.2)), ("sigma_t", "thick")]
APART = {"alpha_u": 0.01, "alpha_v": 1.0}, {"alpha_u": 0.3, "alpha_v": 0.01}


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda m, _: layer(GOLD, m), "urushi.dielectric"),
        *((lambda m, _, n=n, x=x: layer(TOP, m, **{n: x}), f"the coat's {n}") for n, x in WRONG),
        (lambda m, _: layer(TOP, codes(5, m), albedo=(0.1, 0.2, 0.3)), "three values, .* has 5"),
        *((lambda m, _, a=a: layer(TOP, conductor(**a, r0=0.9)), RATIO) for a in APART),
        *((lambda m, _, a=a: layer(dielectric(**a), diffuse(0.5)), RATIO) for a in APART),
        (lambda m, _: layer(SATIN, GOLD, energy_compensation=True), r"give it to urushi\.coat"),
        (lambda m, other: lerp(m, Material(m.latents, other), 0.5), "different weights"),
        (lambda m, _: lerp(m, GOLD, 0.5), "encode it into a Material"),
        (lambda m, _: lerp(m, codes(2, m), 0.5), "does not fit"),
        *(
            (lambda m, _, t=t: lerp(m, m, t), "lerp's t")
            for t in (-0.1, 1.1, np.nan, (0.1, 0.2), np.zeros((2, 3)), "half")
        ),
    ],
)
def test_mistakes_are_named(call, sentence, material, other_model):
    with pytest.raises(ParameterError, match=sentence):
        call(material, other_model)


def test_lerp_is_exact_at_its_ends(material):
    other = layer(TOP, material, albedo=0.5, sigma_t=1)
    assert lerp(material, other, 0) == material and lerp(material, other, 1) == other
    mixed = lerp(material, other, (0, 0.5, 1)).latents
    assert np.array_equal(mixed[0], material.latents[0])
    assert np.array_equal(mixed[2], other.latents[2])
    assert np.array_equal(mixed[1], lerp(material, other, 0.5).latents[1])


@pytest.mark.parametrize(
    ("sigma_t", "g"), [(9.0, 0.0), (20.0, 0.0), (1e4, 0.7), (1e6, 0.0), (2.0, -0.99), (2.0, 0.99)]
)
def test_a_white_medium_outside_the_training_data_stays_white(trained, sigma_t, g):
    """Nothing absorbs, so that the albedo is 1 but for a bottom whose code is 0.995.

    Light meets it a few times. Grazing light of rough coats is lost between facets.
    """
    enamel = layer(dielectric(0.01, 1.5), diffuse(1.0), albedo=1.0, sigma_t=sigma_t, g=g)
    wi = at_cosines([1.0, 0.9, 0.6])
    most = 0.03 if g > -0.9 else 0.06  # a table has few nodes across a backward peak
    np.testing.assert_allclose(enamel.directional_albedo(wi), 1, atol=most)


def test_codes_outside_the_training_data_are_warned_of():
    with pytest.warns(UrushiWarning, match=r"g is outside \[-0.8, 0.9\] and sigma_t is above 8"):
        layer(TOP, diffuse(0.5), sigma_t=9.0, g=-0.9, fast=True)
