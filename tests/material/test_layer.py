"""Coating and blending in the latent space: shapes, channels, identities, bad input."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.errors import ParameterError, UrushiWarning
from urushi.material import Material, encode, layer, lerp
from urushi.material.layer import within_training
from urushi.walk import conductor, dielectric, diffuse

TOP = dielectric(0.1, 1.5)


def test_an_empty_medium_has_no_albedo_and_no_g(material):
    clear = layer(TOP, material, sigma_t=0)
    assert clear == layer(TOP, material, albedo=0.9, sigma_t=0, g=0.8)
    assert clear != layer(TOP, material, albedo=0.9, sigma_t=0.1)


def test_coats_nest_and_encodable_bottoms_are_encoded(model):
    gold = conductor(0.2, (0.98, 0.77, 0.34))
    once = layer(TOP, gold, albedo=0.8, sigma_t=1, weights=model)
    assert once == layer(TOP, encode(gold, model), albedo=0.8, sigma_t=1)
    assert layer(TOP, once).channels == 3


def test_one_channel_grows_to_three(model):
    grey = Material(np.ones((1, 14)), model)
    medium = {"sigma_t": 1, "fast": True}
    assert layer(TOP, grey, albedo=0.5, **medium).channels == 1
    assert layer(TOP, grey, albedo=(0.1, 0.5, 0.9), **medium).channels == 3


@pytest.mark.parametrize(
    "wrong",
    [
        {"albedo": 1.1}, {"albedo": -0.1}, {"sigma_t": -1}, {"sigma_t": np.nan}, {"g": 1},
        {"g": -1.0}, {"albedo": (0.1, 0.2)}, {"sigma_t": "thick"}, {"sigma_t": np.inf},
    ],
)  # fmt: skip
def test_bad_parameters_are_named(wrong, material):
    with pytest.raises(ParameterError, match=f"the coat's {next(iter(wrong))}"):
        layer(TOP, material, **wrong)


def test_only_a_dielectric_coats(material):
    with pytest.raises(ParameterError, match="urushi.dielectric"):
        layer(conductor(0.1, 0.9), material)


def test_three_values_do_not_fit_five_channels(model):
    wide = Material(np.ones((5, 14)), model)
    assert layer(TOP, wide, albedo=0.5, sigma_t=1, fast=True).channels == 5
    with pytest.raises(ParameterError, match="albedo has three values, but the bottom has 5"):
        layer(TOP, wide, albedo=(0.1, 0.2, 0.3), sigma_t=1)


def test_lerp_is_exact_at_its_ends(material):
    other = layer(TOP, material, albedo=0.5, sigma_t=1)
    assert lerp(material, other, 0) == material and lerp(material, other, 1) == other
    mixed = lerp(material, other, (0, 0.5, 1)).latents
    assert np.array_equal(mixed[0], material.latents[0])
    assert np.array_equal(mixed[2], other.latents[2])
    assert np.array_equal(mixed[1], lerp(material, other, 0.5).latents[1])


def test_lerp_of_one_and_three_channels(material, model):
    assert lerp(material, Material(np.ones((1, 14)), model), 0.5).channels == 3


def test_lerp_refuses_strangers(material, model, other_model):
    with pytest.raises(ParameterError, match="different weights"):
        lerp(material, Material(material.latents, other_model), 0.5)
    with pytest.raises(ParameterError, match="encode it into a Material"):
        lerp(material, conductor(0.1, 0.9), 0.5)
    with pytest.raises(ParameterError, match="does not fit"):
        lerp(material, Material(np.ones((2, 14)), model), 0.5)


@pytest.mark.parametrize("t", [-0.1, 1.1, np.nan, (0.1, 0.2), np.zeros((2, 3)), "half"])
def test_lerp_refuses_bad_shares(t, material):
    with pytest.raises(ParameterError, match="lerp's t"):
        lerp(material, material, t)


@pytest.mark.parametrize(
    ("sigma_t", "g"), [(9.0, 0.0), (20.0, 0.0), (1e4, 0.7), (1e6, 0.0), (2.0, -0.99), (2.0, 0.99)]
)
def test_a_white_medium_outside_the_training_data_stays_white(trained, sigma_t, g):
    """Nothing absorbs, so that the albedo is 1 but for a bottom whose code is 0.995.

    Light meets it a few times. Grazing light of rough coats is lost between facets.
    """
    enamel = layer(dielectric(0.01, 1.5), diffuse(1.0), albedo=1.0, sigma_t=sigma_t, g=g)
    cosines = np.array([1.0, 0.9, 0.6])
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
    most = 0.03 if g > -0.9 else 0.06  # a table has few nodes across a backward peak
    np.testing.assert_allclose(enamel.directional_albedo(wi), 1, atol=most)


def test_codes_outside_the_training_data_are_warned_of():
    with pytest.warns(UrushiWarning, match=r"g is outside \[-0.8, 0.9\] and sigma_t is above 8"):
        layer(TOP, diffuse(0.5), sigma_t=9.0, g=-0.9, fast=True)


def test_media_of_the_training_data_are_not_changed():
    shape = np.random.default_rng(0).random((4, 3))
    inside = CoatParameters(np.array(0.1), np.array(1.5), shape, 8 * shape, 0.9 * shape)
    assert within_training(inside) is inside


@pytest.mark.parametrize("widths", [(0.01, 1.0), (0.3, 0.01)])
def test_widths_far_apart_are_refused(widths):
    alpha = dict(zip(("alpha_u", "alpha_v"), widths, strict=True))
    for top, bottom in (
        (TOP, conductor(**alpha, r0=0.9)),
        (dielectric(**alpha, eta=1.5), diffuse(0.5)),
    ):
        with pytest.raises(ParameterError, match=r"alpha_u and alpha_v have a ratio of (100|30)"):
            layer(top, bottom)
