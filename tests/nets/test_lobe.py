"""The analytic lobe: reciprocal to the bit, finite, and linear; its features."""

import math

import numpy as np
import pytest

from urushi.nets import lobe


@pytest.fixture
def lobes(random_lobes):
    """300 lobes of all kinds in double precision."""
    return random_lobes(300, np.random.default_rng(1))


def test_f_is_reciprocal_to_the_bit(lobes, pairs):
    wi, wo = pairs
    lobes = lobes.astype(np.float32)[:, None]
    f = lobe.f(lobes, wi, wo)
    assert f.dtype == np.float32
    assert np.array_equal(f, lobe.f(lobes, wo, wi))
    assert (f >= 0).all()


def test_f_is_finite_at_the_horizon_and_at_the_mirror_direction(lobes):
    up, flat = [0, 0, 1], [1, 0, 0]
    slanted = [math.sqrt(1 - 1e-6), 0, 1e-3]
    mirrored = [-slanted[0], 0, slanted[2]]
    below = [0.6, 0, -0.8]
    cases = [(up, up), (flat, up), (flat, flat), (flat, [-1, 0, 0]), (slanted, mirrored),
             (mirrored, flat), (below, up), (below, below), (below, [-0.6, 0, 0.8])]  # fmt: skip
    wi, wo = (np.array(w, np.float32) for w in zip(*cases, strict=True))
    f = lobe.f(lobes.astype(np.float32)[:, None], wi, wo)
    assert np.isfinite(f).all()
    # Head-on on a mirror-like surface: D = 1 / (pi alpha^2), G = 1.
    expected = 0.04 / (4 * math.pi * 1e-4)
    head_on = lobe.f(np.array(lobe.of_coat(np.array(0.01), np.array(1.5))), wi[0], wo[0])
    assert head_on == pytest.approx(expected, rel=1e-5)


def test_f_is_linear_in_the_factors(lobes, pairs):
    wi, wo = (w.astype(np.float64)[::20] for w in pairs)
    factor = np.random.default_rng(4).random((len(lobes), 1))
    scaled = lobes.copy()
    scaled[:, 1:4] *= factor
    expected = factor * lobe.f(lobes[:, None], wi, wo)
    np.testing.assert_allclose(lobe.f(scaled[:, None], wi, wo), expected, rtol=1e-12)


def test_features_are_finite_and_of_about_unit_size(random_lobes):
    features = lobe.lobe_features(random_lobes(4000, np.random.default_rng(5)).astype(np.float32))
    assert features.dtype == np.float32
    assert features.shape == (4000, lobe.LOBE_FEATURES[1])
    assert np.isfinite(features).all()
    assert np.abs(features).max() < 8


def test_the_width_of_an_invisible_lobe_does_not_matter():
    none = np.tile(np.array(lobe.NO_LOBE), (5, 1))
    none[:, 0], none[:, 4] = np.geomspace(0.01, 1, 5), np.linspace(0.5, 3, 5)
    features = lobe.lobe_features(none)
    assert np.array_equal(features, np.broadcast_to(features[0], features.shape))
