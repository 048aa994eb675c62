"""The bidirectional estimator: the walk's means, whatever the number of light vertices."""

import functools

import numpy as np
import pytest
from research import bidirectional
from tests.oracles import adding_doubling

from urushi.walk import coat, conductor, diffuse, simulate
from urushi.walk.monte_carlo import average
from urushi.walk.table import from_stack

WALKS = 1 << 14
METAL = conductor(alpha=0.4, r0=0.9)
STACKS = {
    "clear": coat(METAL, 0.2, 1.5, albedo=1, sigma_t=0),
    "absorbing": coat(METAL, 0.2, 1.5, albedo=0, sigma_t=1),
    "milky": coat(diffuse(0.7), 0.2, 1.5, albedo=0.9, sigma_t=1),
    "forward": coat(METAL, 0.1, 1.5, albedo=0.95, sigma_t=2, g=0.9),
    "thick": coat(diffuse(0.3), 0.1, 1.5, albedo=0.99, sigma_t=6, g=0.7),
    "three clear": coat(coat(METAL, 0.3, 1.3, 1, 0), 0.2, 1.5, albedo=1, sigma_t=0),
    "three": coat(coat(METAL, 0.3, 1.3, 0.9, 0.5, 0.5), 0.2, 1.5, 0.8, 1, -0.4),
    "low": coat(coat(diffuse(0.7), 0.3, 0.7, 0.9, 0.5, 0.5), 0.2, 1.5, 0.8, 1, -0.4),
    "anisotropic": coat(
        conductor(alpha_u=0.5, alpha_v=0.2, r0=0.9),
        eta=1.5,
        albedo=0.9,
        sigma_t=0.5,
        alpha_u=0.1,
        alpha_v=0.3,
    ),
}


def pairs(count, seed):
    """Pairs (count, 3) of directions whose cosines are at least 0.2."""
    rng = np.random.default_rng(seed)
    cosine, angle = rng.uniform(0.2, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    sine = np.sqrt(1 - cosine**2)
    return np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], axis=-1)


def walked(stack, wi, wo, seed, estimate=bidirectional.simulate):
    """f and standard error (N,) of the first channel."""
    f, se = estimate(stack, wi, wo, walks=WALKS, seed=seed)
    return f[:, 0].astype(float), se[:, 0].astype(float)


def assert_equal_means(first, second):
    """The mean of z^2 of N normal differences is 1 with a standard deviation of sqrt(2 / N)."""
    z = (first[0] - second[0]) / np.hypot(first[1], second[1])
    # Skewed noise of rare bright walks widens z a little.
    assert (z**2).mean() < 1 + 5 * np.sqrt(2 / len(z)) and abs(z.mean()) < 4 / np.sqrt(len(z))
    bias = (first[0].sum() - second[0].sum()) / second[0].sum()
    assert abs(bias) < 0.01


@pytest.mark.parametrize("name", STACKS)
def test_both_estimators_have_the_same_mean(name):
    wi, wo = pairs(24, seed=1)
    assert_equal_means(walked(STACKS[name], wi, wo, 2), walked(STACKS[name], wi, wo, 3, simulate))


@pytest.mark.parametrize("count", [1, 2, 6])
def test_the_mean_does_not_depend_on_the_number_of_light_vertices(count):
    wi, wo = (w.astype(np.float32) for w in pairs(24, seed=4))
    row = np.zeros(len(wi), np.uint32)
    found = [
        average(
            from_stack(STACKS["milky"]),
            row,
            (wi, wo),
            functools.partial(estimate, count=vertices),
            walks=WALKS,
            seed=vertices,
        )
        for vertices in (count, bidirectional.LIGHT_VERTICES)
    ]
    assert_equal_means(*found)


def estimate(layers, bottom, wi, wo, rng, count):
    return bidirectional.estimate(layers, bottom, wi, wo, rng, type(wi.z), count=count)


@pytest.mark.parametrize("name", ["milky", "three"])
def test_it_agrees_with_adding_and_doubling(name):
    wi, wo = pairs(24, seed=5)
    f, se = walked(STACKS[name], wi, wo, 6)
    expected = adding_doubling.solve(STACKS[name], wi, wo)[:, 0]
    # Adding and doubling has an error of its nodes, 0.5 % here.
    assert_equal_means((f, np.hypot(se, 0.005 * f)), (expected, 0 * f))


@pytest.mark.parametrize("name", ["forward", "three", "low"])
def test_reciprocity(name):
    wi, wo = pairs(24, seed=7)
    assert_equal_means(walked(STACKS[name], wi, wo, 8), walked(STACKS[name], wo, wi, 9))


def test_forward_scattering_has_less_noise_than_one_walk():
    wi, wo = pairs(24, seed=10)
    both, one = (
        walked(STACKS["forward"], wi, wo, 11, estimate)[1]
        for estimate in (bidirectional.simulate, simulate)
    )
    assert (both**2).mean() < 0.5 * (one**2).mean()


def test_directions_below_the_horizon_give_zero():
    wi, wo = pairs(4, seed=12)
    wo[:, 2] *= -1
    f, se = walked(STACKS["milky"], wi, wo, 13)
    assert not f.any() and not se.any()
