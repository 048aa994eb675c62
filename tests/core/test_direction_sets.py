"""Direction sets: unit vectors above the horizon with the stated densities."""

import numpy as np
import pytest
from scipy import stats

from urushi.core import direction_sets
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.errors import ParameterError

N = 20_000


def draw(name, seed=0, n=N):
    return direction_sets.DIRECTION_SETS[name](np.random.default_rng(seed), n)


def half_tangent(wi, wo):
    h = wi.astype(np.float64) + wo.astype(np.float64)
    return np.hypot(h[:, 0], h[:, 1]) / h[:, 2]


@pytest.mark.parametrize("name", direction_sets.DIRECTION_SETS)
def test_pairs_are_unit_vectors_above_the_horizon(name):
    for w in draw(name):
        assert w.dtype == np.float32
        assert w.shape == (N, 3)
        assert w[:, 2].min() > 0
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)  # float32 rounding


@pytest.mark.parametrize("name", direction_sets.DIRECTION_SETS)
def test_same_seed_gives_the_same_bits_and_another_does_not(name):
    first, again, other = draw(name), draw(name), draw(name, seed=1)
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a, b)
        assert (a != c).any()


def test_cosine_pairs_have_cosine_density_on_both_sides():
    # cos^2(theta) is uniform; KS at the 0.1 % level with a fixed seed.
    for w in draw("cosine"):
        assert stats.kstest(w[:, 2] ** 2, "uniform").pvalue > 1e-3
        azimuth = np.arctan2(w[:, 1], w[:, 0])
        assert stats.kstest(azimuth, "uniform", args=(-np.pi, 2 * np.pi)).pvalue > 1e-3


def test_both_directions_of_a_cosine_pair_are_independent():
    wi, wo = draw("cosine")
    # The correlation of n independent pairs has a standard deviation of 1 / sqrt(n): 4 of them.
    for axis in range(3):
        assert abs(np.corrcoef(wi[:, axis], wo[:, axis])[0, 1]) < 4 / np.sqrt(N)


def test_uniform_pairs_have_uniform_cosines():
    for w in direction_sets.uniform_pairs(np.random.default_rng(0), N):
        assert stats.kstest(w[:, 2], "uniform").pvalue > 1e-3


def test_half_angles_are_log_uniform_where_no_pair_is_rejected():
    wi, wo = draw("half_angle")
    tangent = half_tangent(wi, wo)
    low, high = direction_sets.METRIC_HALF_ANGLE_RANGE
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


def test_a_quarter_of_grazing_pairs_has_a_log_uniform_cosine_over_cosine_density():
    wi, wo = (w[3::4].astype(np.float64) for w in draw("grazing", n=4 * N))
    lowest = np.log(direction_sets.LOWEST_COSINE)
    # KS at the 0.1 % level with a fixed seed. The float32 cosine is off by 1e-5 at the lowest.
    assert stats.kstest(np.log(wi[:, 2]), "uniform", args=(lowest, -lowest)).pvalue > 1e-3
    assert stats.kstest(wo[:, 2] ** 2, "uniform").pvalue > 1e-3


def test_three_quarters_of_grazing_pairs_are_training_pairs():
    training, grazing = draw("training"), draw("grazing")
    for a, b in zip(training, grazing, strict=True):
        for start in (0, 1, 2):
            np.testing.assert_array_equal(a[start::4], b[start::4])


def test_training_pairs_have_the_same_mixture_in_every_run_and_avoid_the_horizon():
    wi, wo = draw("training")
    assert min(wi[:, 2].min(), wo[:, 2].min()) > direction_sets.LOWEST_COSINE
    tangent = half_tangent(wi, wo)
    # The even pairs are spread in log half angle: without the rejections, which take wide angles
    # away, 1 / 8 + 7 / 8 ln(0.035 / 5e-4) / ln(8 / 5e-4) = 51 % of them would be this close to
    # the mirror direction. Hemispherical pairs rarely are.
    even, odd = tangent[::2], tangent[1::2]
    assert 0.5 < (even < 0.035).mean() < 0.7
    assert (odd < 0.035).mean() < 0.02
    # Cosine and uniform pairs alternate: their mean cosines are 2/3 and 1/2.
    assert abs(wi[1::4, 2].mean() - 2 / 3) < 0.02
    assert abs(wi[3::4, 2].mean() - 1 / 2) < 0.02


@pytest.mark.parametrize("name", ["training", "grazing"])
def test_training_pairs_reach_the_exact_mirror_direction(name):
    wi, wo = (w[::2] for w in draw(name, n=4 * N))
    tangent = half_tangent(wi, wo)
    # Rounding to float32 turns the half vector by at most 6e-8 / LOWEST_COSINE.
    exact = (tangent < 3e-5).mean()
    near = tangent[(tangent > 3e-5) & (tangent < 5e-4)]
    # A sixteenth of the pairs before rejections, which nearly all spare the mirror direction and
    # take a sixth to a quarter of all others.
    assert 1 / 16 < exact < 1 / 12
    # Below the log-uniform range, tan(theta_h) is uniform.
    assert stats.kstest(near, "uniform", args=(3e-5, 4.7e-4)).pvalue > 1e-3


def test_probed_stacks_each_begin_with_the_encoders_probe_pairs():
    pairs = PROBES + 16
    wi, wo = direction_sets.draw_pairs("probed", np.random.default_rng(7), 3, pairs)
    probes = probe_pairs(PROBES)
    for stack in np.split(np.arange(3 * pairs), 3):
        known, others = stack[:PROBES], stack[PROBES:]
        assert np.array_equal(wi[known], probes[0]) and np.array_equal(wo[known], probes[1])
        assert not np.isin(wi[others], probes[0]).all(axis=1).any()
    with pytest.raises(ParameterError, match=f"part 'x' has {PROBES} probed pairs; give more"):
        direction_sets.check_set("probed", PROBES, "part 'x'")
