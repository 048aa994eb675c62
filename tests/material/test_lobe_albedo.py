"""Albedos of lobes by tabulated Gauss rules agree with a fine quadrature, and never exceed one."""

import numpy as np
import pytest

from urushi.geometry import quadrature
from urushi.material.albedo_rule import albedo_rule
from urushi.material.lobe_albedo import REMEMBERED_ROWS, lobe_albedos
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
    error = np.abs(lobe_albedos(lobe, cosines) - expected)
    assert error.max() < (0.03 if fresnel == "inside" else 0.003)


@pytest.mark.parametrize("fresnel", FRESNEL)
def test_no_lobe_reflects_more_than_arrives(fresnel):
    widths = np.exp(np.random.default_rng(0).uniform(np.log(0.01), 0, 100))
    lobe = np.stack([np.array([alpha, *FRESNEL[fresnel]], np.float32) for alpha in widths])
    assert lobe_albedos(lobe, albedo_rule().cosines).max() <= 1 + 1e-6


def test_one_lobe_and_many_give_the_same():
    many = np.tile(np.array([0.2, *FRESNEL["glass"]], np.float32), (2 * REMEMBERED_ROWS, 1))
    many[:, 0] = np.linspace(0.01, 1, len(many))
    cosines = albedo_rule().cosines
    together = lobe_albedos(many.reshape(2, -1, 6), cosines)
    assert together.shape == (2, REMEMBERED_ROWS, len(cosines))
    for k in (0, REMEMBERED_ROWS - 1):
        np.testing.assert_array_equal(together[0, k], lobe_albedos(many[k], cosines))


def test_no_lobes_have_no_albedos():
    cosines = albedo_rule().cosines
    assert lobe_albedos(np.zeros((0, 3, 6), np.float32), cosines).shape == (0, 3, len(cosines))
