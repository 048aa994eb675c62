"""Anisotropic materials of the shipped networks: networks are chosen, frames turn, laws hold."""

from dataclasses import replace

import numpy as np
import pytest
from tests.directions import at_cosines
from tests.material.conftest import error

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.errors import ParameterError, UrushiWarning
from urushi.nets.weights import anisotropic_model, default_model
from urushi.walk import analytic

BRUSHED = urushi.conductor(alpha_u=0.3, alpha_v=0.08, eta=0.2, k=3.9)
GREY = urushi.diffuse(0.5)
SATIN = urushi.dielectric(alpha_u=0.1, alpha_v=0.4, eta=1.5)


PAIRS = cosine_pairs(np.random.default_rng(0), 1500, lowest_cosine=0.02)


@pytest.fixture(scope="module")
def lacquered():
    """Brushed metal under an isotropic lacquer, and under a satin one."""
    medium = {"albedo": 0.4, "sigma_t": [0.1, 0.5, 1.0]}
    plain = urushi.layer(urushi.dielectric(alpha=0.15, eta=1.5), BRUSHED, **medium)
    return plain, urushi.layer(SATIN, BRUSHED, **medium)


def test_networks_follow_the_surface():
    isotropic, anisotropic = default_model(), anisotropic_model()
    assert anisotropic.widths == 2 and isotropic.widths == 1
    assert urushi.encode(BRUSHED).model is anisotropic
    assert urushi.encode(urushi.conductor(alpha_u=0.2, alpha_v=0.2, r0=0.8)).model is isotropic
    coated = urushi.layer(SATIN, GREY, fast=True)
    assert coated.model is anisotropic
    assert urushi.layer(urushi.dielectric(), coated, fast=True).model is anisotropic
    encoded = urushi.encode(GREY)
    assert urushi.layer(SATIN, encoded, fast=True).model is anisotropic
    assert urushi.layer(urushi.dielectric(), GREY, fast=True).model is isotropic


def test_sources_of_values_keep_their_anisotropy():
    """A function is tested: isotropic ones get isotropic networks, others two widths."""

    def f(wi, wo):
        return analytic.f(BRUSHED, wi, wo) + 0.05

    material = urushi.encode(f)
    assert material.model is anisotropic_model()
    assert error(material, f(*PAIRS), *PAIRS).max() < 0.03
    assert urushi.encode(lambda wi, wo: np.full((len(wi), 3), 0.1)).model is default_model()
    with pytest.warns(UrushiWarning, match="anisotropic: it differs by"):
        assert urushi.encode(f, "default").model is default_model()


def test_a_source_that_is_turned_is_averaged_about_the_tangent():
    """Mirrored at the tangent, a lobe of an axis at 30 degrees becomes another BRDF."""
    with pytest.warns(UrushiWarning, match="not symmetric about its tangent"):
        urushi.encode(
            lambda wi, wo: analytic.f(BRUSHED, rotated(wi, -1 / 12), rotated(wo, -1 / 12))
        )


def test_bare_surfaces_are_exact():
    material = urushi.encode(BRUSHED)
    np.testing.assert_allclose(material.f(*PAIRS), analytic.f(BRUSHED, *PAIRS), rtol=1e-4)
    assert material.model.networks.table(material.latents) is None


@pytest.mark.parametrize("axis", [0, 1])
def test_f_is_continuous_where_a_half_vector_crosses_an_axis(lacquered, axis):
    """Near the horizon, 2e-5 of a direction changes its cosine by a few per cent; near the normal,
    it changes the azimuth of the half vector by as much."""
    wi = PAIRS[0].astype(np.float32)
    for material in lacquered:
        sides = []
        for offset in (-1e-5, 1e-5):
            wo = PAIRS[1].astype(np.float32)
            wo[:, axis] = offset - wi[:, axis]
            wo[:, 2] = np.sqrt(np.maximum(1 - (wo[:, :2] ** 2).sum(axis=1), 0))
            sides.append(material.f(wi, wo / np.linalg.norm(wo, axis=1, keepdims=True)))
        half = wi + wo
        seen = (wi[:, 2] > 0.1) & (wo[:, 2] > 0.1) & (np.abs(half[:, 1 - axis]) > 0.02 * half[:, 2])
        assert seen.sum() > 200
        np.testing.assert_allclose(sides[0][seen], sides[1][seen], rtol=0.01)


def test_no_azimuth_gains_energy():
    """White metal under clear coats; the quadrature of half vectors is good to 0.003 here."""
    white = urushi.conductor(alpha_u=0.4, alpha_v=0.1, r0=1.0)
    wi = at_cosines(np.tile((0.95, 0.6, 0.3), 5), np.repeat(np.linspace(0, np.pi / 2, 5), 3))
    for top in (urushi.dielectric(alpha=0.3, eta=1.5), SATIN):
        assert urushi.layer(top, white).directional_albedo(wi).max() < 1.007


def test_a_turned_material_is_seen_from_the_turned_frame(lacquered, tmp_path):
    wi, wo = PAIRS
    material = lacquered[1]
    other = material.rotated(40)
    assert other.rotation == 40 and other.rotated(-40) == material
    sides = rotated(wi, 1 / 9), rotated(wo, 1 / 9)
    np.testing.assert_allclose(other.f(*sides), material.f(wi, wo), rtol=2e-3)
    np.testing.assert_allclose(other.pdf(*sides), material.pdf(wi, wo), rtol=2e-3)
    u = np.random.default_rng(1).random((len(wi), 3))
    sample, pdf = other.sample(sides[0], u)
    np.testing.assert_allclose(pdf, other.pdf(sides[0], sample), rtol=1e-3)
    expected = material.directional_albedo(wi[:8])
    np.testing.assert_allclose(other.directional_albedo(sides[0][:8]), expected, rtol=1e-4)
    other.save(tmp_path / "turned.safetensors")
    assert urushi.load(tmp_path / "turned.safetensors") == other
    plain = urushi.encode(urushi.diffuse(0.3))
    assert plain.rotated(30) is plain


def test_a_quarter_turn_exchanges_the_widths():
    """Nearly: the networks learned both, and differ by their errors."""
    top = urushi.dielectric(alpha_u=0.4, alpha_v=0.1, eta=1.5)
    turned = urushi.layer(SATIN, GREY).rotated(90)
    assert error(turned, urushi.layer(top, GREY), *PAIRS).max() < 0.03


def test_layers_share_one_tangent(lacquered):
    isotropic = urushi.dielectric(alpha=0.2, eta=1.4)
    assert urushi.layer(isotropic, lacquered[0].rotated(25), fast=True).rotation == 25
    assert urushi.layer(SATIN, lacquered[0].rotated(180), fast=True).rotation == 180


@pytest.mark.slow
def test_blends(lacquered):
    a, b = lacquered
    assert urushi.lerp(a, b, 0) == urushi.lerp(a, a, 0.0) == a
    f = urushi.lerp(a, b, 0.5).f(*PAIRS)
    assert np.isfinite(f).all() and (f > 0).all()
    plain = urushi.encode(GREY)
    for angle in (20.0, -20.0):
        assert urushi.lerp(plain, replace(a, rotation=angle), 0.5).rotation == angle
    assert urushi.lerp(plain, a, 0.5).model is anisotropic_model()


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda x: x.rotated(float("nan")), "rotation"),
        (lambda x: x.rotated((10, 20, 30)), "rotation must be one number"),
        (lambda x: urushi.layer(SATIN, GREY, weights="default"), "weights are for isotropic mat"),
        (lambda x: urushi.encode(urushi.coat(BRUSHED, 0.1, 1.5), "default"), "Stack.*isotropic"),
        (lambda x: urushi.layer(SATIN, x.rotated(25)), "rotated by 25 degrees.*share one tangent"),
        (lambda x: urushi.lerp(x.rotated(10), x, 0.5), "rotated by 10 and 0 degrees"),
    ],
)
def test_bad_input_is_named(call, sentence, lacquered):
    with pytest.raises(ParameterError, match=sentence):
        call(lacquered[0])


@pytest.mark.parametrize("alpha_v", [0.115, 0.94])
def test_coats_over_the_values_of_a_very_wide_lobe(alpha_v):
    """A GGX conductor with correlated masking (Heitz 2014), whose lobe is fitted, under coats.

    The rest that the fitted lobe leaves has a code outside of all training. Coats over it were 13
    to 30 % wrong, and for some widths 10^8 times too bright. Separable masking, which the networks
    know, differs under a coat by 1 %. Where some of the rest is kept, networks err by up to 5 %.
    """
    surface = urushi.conductor(alpha_u=1.0, alpha_v=alpha_v, r0=(0.4, 0.3, 0.7))

    def correlated(wi, wo):
        slopes = [np.hypot(w[:, 0], alpha_v * w[:, 1]) / w[:, 2] for w in (wi, wo)]
        roots = [np.hypot(1, slope) for slope in slopes]
        product, total = 0.25 * (1 + roots[0]) * (1 + roots[1]), 0.5 * (roots[0] + roots[1])
        return analytic.f(surface, wi, wo) * (product / total)[:, None]

    wi, wo = cosine_pairs(np.random.default_rng(3), 2000)
    encoded = urushi.encode(correlated, "anisotropic")
    for alpha, eta, sigma_t in ((0.06, 2.1, 0.0), (0.1, 1.5, 1.0)):
        top = urushi.dielectric(alpha, eta)
        found, expected = (urushi.layer(top, x, sigma_t=sigma_t) for x in (encoded, surface))
        assert error(found, expected, wi, wo).max() < 0.07
