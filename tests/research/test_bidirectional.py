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


@pytest.mark.parametrize("name", STACKS)
def test_both_estimators_have_the_same_mean(name):
    """The mean of z^2 of N normal differences is 1 with a standard deviation of sqrt(2 / N)."""
    pairs = pairs_above(24, 1, 0.2)
    (f, se), (expected, error) = (
        [x[:, 0].astype(float) for x in estimate(STACKS[name], *pairs, walks=WALKS, seed=seed)]
        for estimate, seed in ((bidirectional.simulate, 2), (simulate, 3))
    )
    z = (f - expected) / np.hypot(se, error)
    # Skewed noise of rare bright walks widens z a little.
    assert (z**2).mean() < 1 + 5 * np.sqrt(2 / len(z)) and abs(z.mean()) < 4 / np.sqrt(len(z))
    assert f.sum() == pytest.approx(expected.sum(), rel=0.01)
