"""The bidirectional estimator: the walk's means, whatever the number of light vertices."""

import numpy as np
import pytest
from research import bidirectional
from tests.directions import pairs_above

from urushi.walk import coat, conductor, diffuse, simulate

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
        conductor(alpha_u=0.5, alpha_v=0.2, r0=0.9), None, 1.5, 0.9, 0.5, alpha_u=0.1, alpha_v=0.3
    ),
}


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
    wi, wo = pairs_above(24, 1, 0.2)
    assert_equal_means(walked(STACKS[name], wi, wo, 2), walked(STACKS[name], wi, wo, 3, simulate))
