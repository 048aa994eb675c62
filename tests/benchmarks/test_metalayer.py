"""The BSDFNet: its published sizes, its harmonics, and what it learns."""

import numpy as np
import pytest
from benchmarks.rivals import metalayer
from benchmarks.rivals.ggx_fit import GgxFit, Lobe

from urushi.core.direction_sets import cosine_pairs


@pytest.fixture
def plastic():
    return GgxFit(np.array([0.4, 0.2, 0.1]), (Lobe(0.3, 0.1, np.ones(3)),))


def test_the_sizes_are_the_published_ones():
    weights = metalayer.initial(np.random.default_rng(0))
    common, own = metalayer.size(weights)
    # 168 inputs, "over 13K" common weights, and 293 numbers of a channel
    assert (metalayer.INPUTS, common, own) == (168, 13_468, 3 * 293)


def test_harmonics_are_orthonormal():
    """An exact rule: Gauss nodes of the height and even azimuths, for products of degree 16."""
    z, weight = np.polynomial.legendre.leggauss(9)
    phi = np.arange(17) * (2 * np.pi / 17)
    z, weight, phi = (a.ravel() for a in np.broadcast_arrays(z[:, None], weight[:, None], phi))
    r = np.sqrt(1 - z * z)
    values = metalayer.harmonics(np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1))
    gram = values.T @ (values * weight[:, None]) * (2 * np.pi / 17)
    np.testing.assert_allclose(gram, np.eye(81), atol=1e-12)
    np.testing.assert_allclose(values[:, 2], np.sqrt(3 / (4 * np.pi)) * z)  # l = 1, m = 0


def test_it_learns_a_ggx_lobe_to_a_few_per_cent(plastic):
    learned = metalayer.train(plastic.f, passes=8, samples=60_000)
    wi, wo = cosine_pairs(np.random.default_rng(1), 2000, lowest_cosine=0.02)
    wanted, found = plastic.f(wi, wo), learned.f(wi, wo)
    assert np.abs(found - wanted).mean() < 0.03 * wanted.mean()


def test_it_is_reciprocal_and_isotropic():
    net = metalayer.BsdfNet(metalayer.initial(np.random.default_rng(1)))
    wi, wo = cosine_pairs(np.random.default_rng(2), 100, lowest_cosine=0.02)
    turned = [np.stack([-w[:, 1], w[:, 0], w[:, 2]], axis=-1) for w in (wi, wo)]
    f = net.f(wi, wo)
    assert f.max() > 0
    # Float32 inputs; an azimuth of d next to 0 may become one next to pi, which is the same pair.
    np.testing.assert_allclose(net.f(wo, wi), f, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(net.f(*turned), f, rtol=1e-3, atol=1e-4)


def test_directions_below_the_horizon_give_zero():
    net = metalayer.BsdfNet(metalayer.initial(np.random.default_rng(1)))
    up, down = np.array([[0.6, 0, 0.8]]), np.array([[0.6, 0, -0.8]])
    assert not net.f(up, down).any() and not net.f(down, up).any()


def test_the_same_seed_gives_the_same_network(plastic):
    one, two, other = (
        metalayer.train(plastic.f, passes=1, samples=5_000, seed=seed).weights for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.first[0], two.first[0])
    assert (one.first[0] != other.first[0]).any()
