"""Direction sets: unit vectors above the horizon, with the stated densities or ranges."""

import numpy as np
import pytest
from benchmarks import measures
from scipy import stats

from urushi.core import direction_sets
from urushi.core.probe_pairs import probe_pairs

N = 20_000


def draw(name, seed=0, n=N):
    rng = np.random.default_rng(seed)
    if name == "cosine":
        return direction_sets.cosine_pairs(rng, n)
    return measures.half_angle_pairs(rng, n, slopes=name == "slope")


def half_tangent(wi, wo):
    h = wi.astype(np.float64) + wo.astype(np.float64)
    return np.hypot(h[:, 0], h[:, 1]) / h[:, 2]


@pytest.mark.parametrize("name", ["cosine", "half_angle", "slope"])
def test_pairs_are_unit_vectors_above_the_horizon_and_depend_on_the_seed(name):
    for w, again, other in zip(draw(name), draw(name), draw(name, seed=1), strict=True):
        assert w.dtype == np.float32 and w.shape == (N, 3) and w[:, 2].min() > 0
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)  # float32 rounding
        np.testing.assert_array_equal(w, again)
        assert (w != other).any()


def test_directions_of_cosine_pairs_have_cosine_density_and_are_independent():
    # cos^2(theta) is uniform; KS at the 0.1 % level with a fixed seed.
    wi, wo = draw("cosine")
    for w in (wi, wo):
        assert stats.kstest(w[:, 2] ** 2, "uniform").pvalue > 1e-3
        azimuth = np.arctan2(w[:, 1], w[:, 0])
        assert stats.kstest(azimuth, "uniform", args=(-np.pi, 2 * np.pi)).pvalue > 1e-3
    # The correlation of n independent pairs has a standard deviation of 1 / sqrt(n): 4 of them.
    for axis in range(3):
        assert abs(np.corrcoef(wi[:, axis], wo[:, axis])[0, 1]) < 4 / np.sqrt(N)


def test_half_angles_are_log_uniform_where_no_pair_is_rejected():
    wi, wo = draw("half_angle")
    tangent = half_tangent(wi, wo)
    low, high = measures.HALF_ANGLE_RANGE
    assert tangent.min() > 0.99 * low
    assert tangent.max() < 1.01 * high
    # Below 2 degrees only difference angles within 2 degrees of grazing are rejected: the density
    # of ln tan is level there to 2 / 90.
    small = np.log(tangent[tangent < 0.035])
    counts, _ = np.histogram(small, bins=8, range=(np.log(low), np.log(0.035)))
    np.testing.assert_allclose(counts, counts.mean(), rtol=0.12)  # 4 sigma of about 1000 counts


def test_difference_angles_cover_the_hemisphere_evenly_near_the_mirror_direction():
    wi, wo = (w.astype(np.float64) for w in draw("half_angle"))
    near = half_tangent(wi, wo) < 0.01
    h = wi[near] + wo[near]
    theta_d = np.arccos(np.clip(np.linalg.norm(h, axis=1) / 2, 0, 1))
    inside = theta_d[theta_d < np.radians(89)]
    assert stats.kstest(inside, "uniform", args=(0, np.radians(89))).pvalue > 1e-3


@pytest.mark.parametrize("n", [1, 64, 192, 500])
def test_probes_are_fixed_unit_vectors_above_the_horizon(n):
    for side in probe_pairs(n):
        assert side.shape == (n, 3) and side.dtype == np.float32
        np.testing.assert_allclose(np.linalg.norm(side, axis=1), 1, atol=1e-6)
        assert (side[:, 2] >= 0.0199).all() and not side.flags.writeable


def test_probes_span_half_angles_and_difference_angles():
    wi, wo = (side.astype(np.float64) for side in probe_pairs(192))
    tangent = half_tangent(wi, wo)
    # A lobe of alpha = 0.01 is 0.01 wide in the tangent; several probes must fall in each decade.
    for low in (1e-3, 1e-2, 1e-1):
        assert ((tangent >= low) & (tangent < 10 * low)).sum() >= 20
    difference = np.degrees(np.arccos(np.clip(np.linalg.norm(wi + wo, axis=1) / 2, 0, 1)))
    assert difference.min() < 5 and difference.max() > 80
    assert np.minimum(wi[:, 2], wo[:, 2]).min() < 0.06
