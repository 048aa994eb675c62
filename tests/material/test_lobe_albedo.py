"""Albedos of lobes by tabulated Gauss rules agree with a fine quadrature, and never exceed one."""

import numpy as np
import pytest

from urushi.core import quadrature
from urushi.material.albedo_rule import albedo_rule
from urushi.material.lobe_albedo import (
    anisotropic_albedos,
    isotropic_albedos,
    lobe_albedos,
)
from urushi.nets import lobe as lobes

WIDTHS = (0.01, 0.03, 0.11, 0.35, 1.0)
FRESNEL = {
    "white": (1, 1, 0, 1.5, 0),
    "schlick": (0.3, 1, 0, 1.5, 0),
    "glass": (0, 0, 1, 1.5, 0),
    "gold": (0, 0, 1, 0.2, 3.9),
    "inside": (0, 0, 1, 0.7, 0),
}


@pytest.mark.parametrize("fresnel", FRESNEL)
@pytest.mark.parametrize("alpha", WIDTHS)
def test_they_agree_with_a_fine_quadrature(alpha, fresnel, monkeypatch):
    """To 0.003 from 4 degrees above the horizon; but total reflection has an edge in the angle."""
    monkeypatch.setattr(quadrature, "POLAR_NODES", 192)
    monkeypatch.setattr(quadrature, "AZIMUTH_NODES", 64)
    cosines = np.array([1.0, 0.9, 0.6, 0.3, 0.15, 0.07])
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
    wo, weights = quadrature.half_vector_rule(wi)
    lobe = np.array([alpha, *FRESNEL[fresnel]])
    expected = (lobes.f(lobe, wi[:, None], wo) * wo[..., 2] * weights).sum(axis=1)
    error = np.abs(isotropic_albedos(lobe[None], cosines)[0] - expected)
    assert error.max() < (0.03 if fresnel == "inside" else 0.003)


@pytest.mark.parametrize("fresnel", FRESNEL)
def test_no_lobe_reflects_more_than_arrives(fresnel):
    widths = np.exp(np.random.default_rng(0).uniform(np.log(0.01), 0, 100))
    lobe = np.stack([np.array([alpha, *FRESNEL[fresnel]], np.float32) for alpha in widths])
    assert isotropic_albedos(lobe, albedo_rule().cosines).max() <= 1 + 1e-6


def test_one_lobe_and_many_give_the_same():
    many = np.tile(np.array([0.2, *FRESNEL["glass"]], np.float32), (32, 1))
    many[:, 0] = np.linspace(0.01, 1, len(many))
    rule = albedo_rule()
    together = lobe_albedos(many.reshape(2, -1, 6), rule)
    assert together.shape == (2, 16, len(rule.cosines))
    for k in (0, 15):
        np.testing.assert_array_equal(together[0, k], lobe_albedos(many[k], rule))


def test_no_lobes_have_no_albedos():
    for widths, numbers in ((1, 6), (2, 7)):
        rule = albedo_rule(widths)
        found = lobe_albedos(np.zeros((0, 3, numbers), np.float32), rule)
        assert found.shape == (0, 3, len(rule.cosines))


@pytest.mark.parametrize(
    ("pair", "fresnel"),
    [
        ((0.05, 0.4), "white"),
        ((0.4, 0.05), "gold"),
        ((0.2, 0.1), "schlick"),
        ((0.02, 0.02), "glass"),
    ],
)
def test_two_widths_agree_with_a_fine_quadrature(pair, fresnel, monkeypatch):
    """To 0.004, from 4 degrees above the horizon, at azimuths between the axes as well."""
    monkeypatch.setattr(quadrature, "POLAR_NODES", 256)
    monkeypatch.setattr(quadrature, "AZIMUTH_NODES", 128)
    cosines = np.array([1.0, 0.9, 0.6, 0.3, 0.15, 0.07])
    azimuths = np.array([0.0, 0.5, 0.2, 1.2, 0.9, 0.5 * np.pi])
    sines = np.sqrt(1 - cosines**2)
    wi = np.stack([sines * np.cos(azimuths), sines * np.sin(azimuths), cosines], axis=-1)
    wo, weights = quadrature.half_vector_rule(wi, anisotropic=True)
    lobe = np.array([pair[0], *FRESNEL[fresnel], pair[1]])
    expected = (lobes.f(lobe, wi[:, None], wo) * wo[..., 2] * weights).sum(axis=1)
    found = anisotropic_albedos(lobe[None], wi)[0]
    assert np.abs(found - expected).max() < 0.004


def test_equal_widths_reflect_as_much_as_one():
    """To 0.01: the albedos of two widths are interpolated between seven angles."""
    rule = albedo_rule(2)
    lobe = np.array([[0.15, *FRESNEL["gold"]]], np.float32)
    found = lobe_albedos(lobes.with_two_widths(lobe), rule)
    assert np.abs(found - isotropic_albedos(lobe, rule.cosines)).max() < 0.01
