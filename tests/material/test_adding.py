"""Adding and doubling inside a coat: energy, reciprocity and closed forms."""

import numpy as np
import pytest

from urushi.material import adding
from urushi.nets import lobe as lobes


@pytest.mark.parametrize(("sigma_t", "g"), [(0.3, 0.0), (2.0, 0.6), (5.0, -0.5)])
def test_a_medium_that_absorbs_nothing_keeps_all_light(sigma_t, g):
    own = adding.grid()
    reflected, passed = adding.medium(1.0, sigma_t, g)
    total = (reflected[0] + passed[0]) @ own.weights + np.exp(-sigma_t / own.cosines)
    np.testing.assert_allclose(total, 1, atol=2e-3)
    np.testing.assert_allclose(reflected, np.swapaxes(reflected, 1, 2), atol=1e-8)
    assert own.values_of_modes(reflected).min() > -1e-6


def test_thin_media_scatter_once():
    """f = albedo p (1 - exp(-tau (1 / ci + 1 / co))) / (ci + co), with p = 1 / (4 pi)."""
    own, depth = adding.grid(), 1e-3
    reflected, _ = adding.medium(0.5, depth, 0.0)
    a, b = own.cosines[:, None], own.cosines
    expected = 0.5 / (4 * np.pi) * -np.expm1(-depth * (1 / a + 1 / b)) / (a + b)
    steep = own.cosines > 0.3
    found = own.values_of_modes(reflected)[steep][:, steep, 0]
    np.testing.assert_allclose(found, expected[steep][:, steep], rtol=0.01)


def test_a_lambertian_bottom_below_a_smooth_interface():
    """Diffuse light is reflected back to the bottom by the interface's mean albedo (Saunderson)."""
    own, rho, eta = adding.grid(), 0.7, 1.5
    bottom = adding.bottom_modes(lambda wi, wo: np.full((len(wi), 1), rho / np.pi))[0]
    interface = adding.interface_modes(0.01, eta)
    more, depth = adding.seen_inside(bottom, interface, 0.0, 0.0, 0.0)
    inner = 2 * (interface[0] @ own.weights) @ own.weights
    expected = rho / np.pi / (1 - rho * inner) - rho / np.pi
    np.testing.assert_allclose(more, expected, rtol=1e-4)
    assert depth == 0 and inner == pytest.approx(0.596, abs=0.01)  # Duntley 1942


def test_narrow_lobes_keep_their_albedo():
    metal = np.array([0.03, 1.0, 1.0, 0.0, 1.5, 0.0])
    f = lambda wi, wo: lobes.f(metal, wi.astype(float), wo.astype(float))[:, None]  # noqa: E731
    own = adding.grid()
    modes = adding.bottom_modes(f)[0]
    expected = np.minimum(adding.albedos(f, own.cosines)[:, 0], 1)
    found, steep = modes[0] @ own.weights, own.cosines > 0.2
    np.testing.assert_allclose(found[steep], expected[steep], rtol=1e-6)
    np.testing.assert_allclose(found, expected, rtol=0.05)  # neighbours meet the lobe too
    np.testing.assert_allclose(modes, np.swapaxes(modes, 1, 2), atol=1e-8)


def test_values_between_the_nodes():
    own = adding.grid()
    wi, wo = own.pairs()
    f = 1 + wi[:, 2] * wo[:, 2] + 0.5 * (wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])
    values = own.values(f.astype(float))
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(2, 200, 3))
    pairs[..., 2] = np.abs(pairs[..., 2])
    a, b = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    expected = 1 + a[:, 2] * b[:, 2] + 0.5 * (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])
    found = own.interpolated(values[..., None], a, b)[:, 0]
    np.testing.assert_allclose(found, expected, atol=0.01)
    np.testing.assert_allclose(own.values_of_modes(own.modes(values)), values, atol=1e-12)
