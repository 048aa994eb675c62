"""The random walk: independence of launches, and edge cases."""

import numpy as np
import pytest
from tests.directions import above, pairs_above

from urushi.walk import coat, conductor, dielectric, diffuse, monte_carlo, simulate
from urushi.walk.simulate import albedo

STACK = coat(coat(conductor(0.2, (0.9, 0.6, 0.3)), 0.3, 1.3, 0.9, 1.0, 0.5), 0.1, 1.5, 0.5, 0.3)


def test_a_seed_gives_the_same_numbers_again_and_another_gives_others() -> None:
    """Integers of NumPy are integers."""
    sides = pairs_above(5, 2, 0.1)
    other, first, *again = (
        simulate(STACK, *sides, walks=np.int8(100), seed=seed, progress=False)
        for seed in (8, 7, 7, np.int64(7), np.uint64(7), np.int8(7))
    )
    assert np.all(first[0] != other[0])
    for found in again:
        np.testing.assert_array_equal(found, first)


@pytest.mark.parametrize("lanes", [700, 3000, 1 << 13])
def test_the_result_does_not_depend_on_the_division_into_launches(
    monkeypatch: pytest.MonkeyPatch, lanes: int
) -> None:
    # 700: parts of a row; 3000: three rows; 2^13: eight rows and the last one alone.
    wi, wo = pairs_above(3, 3, 0.1)
    whole = simulate(STACK, wi, wo, walks=1000, seed=1, progress=False)
    monkeypatch.setattr(monte_carlo, "LANES", lanes)
    parts = simulate(STACK, wi, wo, walks=1000, seed=1, progress=False)
    np.testing.assert_allclose(parts[0], whole[0], rtol=1e-5)  # sums of float32 in other orders
    np.testing.assert_allclose(parts[1], whole[1], rtol=1e-3, atol=1e-6)


def test_pairs_and_seeds_are_independent() -> None:
    # The same pair 2000 times: the values' deviation must agree with the standard error.
    wi, wo = above(2, 4, 0.1)[:, None]
    wi, wo = np.repeat(wi, 2000, axis=0), np.repeat(wo, 2000, axis=0)
    stack = coat(diffuse(0.5), 0.3, 1.5, 0.9, 1.0)
    (f, se), (other, _) = (
        simulate(stack, wi, wo, walks=256, seed=seed, progress=False) for seed in (1, 2)
    )
    f, se, other = f[:, 0], se[:, 0], other[:, 0]
    # The deviation of 2000 values is known to 2 %, and slightly worse with long tails.
    assert f.std() == pytest.approx(np.sqrt(np.mean(se**2)), rel=0.1)
    for a, b in ((f, other), (f[1:], f[:-1]), (f[1:], other[:-1])):
        assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(2000)


def test_f_is_zero_below_the_horizon() -> None:
    up, down, level = [0, 0.6, 0.8], [0, 0.6, -0.8], [1, 0, 0]
    wi, wo = [up, down, down, level, up], [down, up, down, up, level]
    for stack in (STACK, coat(diffuse(1.0), 0.5, 1.5)):
        assert not np.any(simulate(stack, wi, wo, walks=64, progress=False))
        assert not np.any(albedo(stack, [down, level], walks=64))


def test_extreme_stacks_stay_finite() -> None:
    z = np.array([1.0, 1e-3, 1e-6, 0.5])
    wi = np.stack([np.sqrt(1 - z * z), 0 * z, z], axis=1)
    wo = wi * [-1, 1, 1]
    bottom = conductor(0.01, 1.0)
    for stack in (
        coat(bottom, 0.01, 1.001, 1.0, 0.0),
        coat(bottom, 0.01, 0.999, 1.0, 0.0),
        coat(bottom, 0.01, 0.5, 1.0, 300.0, 0.999),
        coat(coat(dielectric(1.0, 0.5), 1.0, 0.5, 1.0, 50.0, 0.99), 0.01, 0.5, 0.0, 1e6),
        coat(bottom, 0.01, 3.0, 1.0, 300.0, 0.999),
        coat(diffuse(1.0), 1.0, 3.0, 1.0, 1e-6, -0.999),
        coat(coat(dielectric(1.0, 3.0), 1.0, 3.0, 1.0, 50.0, 0.99), 0.01, 3.0, 0.0, 1e6),
        coat(bottom, 0.01, 1.5, 1.0, 1e6, 0.9),
        coat(conductor(0.01, eta=0.0, k=0.0), 0.01, 1.5),
    ):
        found = np.array(simulate(stack, wi, wo, walks=1 << 7, progress=False))
        assert np.all(np.isfinite(found) & (found >= 0))


@pytest.mark.parametrize("coats", [1, 2])
def test_absorption_is_carried_as_a_weight(coats: int) -> None:
    """If absorption ended walks by chance, only those that survive would contribute.

    The surviving share is at most exp(-sigma_t) per coat on the way down, so that the variance
    would be at least exp(coats sigma_t) - 1, in units of the squared mean.
    """
    stack = diffuse(0.5)
    for _ in range(coats):
        stack = coat(stack, 0.1, 1.3, albedo=0, sigma_t=1.0)
    wi, wo = (above(8, seed, 0.4) for seed in (1, 2))
    f, se = simulate(stack, wi, wo, walks=1 << 12, seed=3, progress=False)
    top = simulate(coat(diffuse(0), 0.1, 1.3), wi, wo, walks=2, progress=False)[0]
    variance = (1 << 12) * (se / (f - top))[:, 0] ** 2
    assert np.median(variance) < 0.2 * np.expm1(coats)
