"""The smooth limit of the walk: closed forms of a smooth slab."""

import numpy as np
import pytest
from tests.oracles import slab

from urushi.walk import coat, conductor, diffuse, simulate
from urushi.walk.simulate import albedo

SIGMA_T = (0.0, 0.25, 0.5)
REFLECTANCE = (0.9, 0.6, 0.5)


def pairs_off_the_mirror() -> tuple[np.ndarray, np.ndarray]:
    """Pairs at 0 to 60 degrees whose half vector is 10 degrees or more from the normal."""
    theta_i, theta_o = (a.ravel() for a in np.meshgrid([0.35, 0.7, 1.05], [0.35, 0.7, 1.05]))
    wi = np.stack([np.sin(theta_i), 0 * theta_i, np.cos(theta_i)], axis=1)
    # The half vector is tilted at a right angle to the plane of incidence.
    wo = np.stack([0 * theta_o, np.sin(theta_o), np.cos(theta_o)], axis=1)
    return wi, wo


@pytest.mark.parametrize("eta", [0.95, 0.999, 1.001, 1.5])
def test_walk_over_a_lambertian_reaches_the_smooth_limit(eta: float) -> None:
    wi, wo = pairs_off_the_mirror()
    stack = coat(diffuse(REFLECTANCE), 0.01, eta, albedo=0.0, sigma_t=SIGMA_T)
    f, se = simulate(stack, wi, wo, walks=20_000, seed=1)
    for channel, (sigma_t, rho) in enumerate(zip(SIGMA_T, REFLECTANCE, strict=True)):
        expected = slab.lambertian_f(wi[:, 2], wo[:, 2], eta, sigma_t, rho)
        # 1 %: GGX has long tails, so that even alpha = 0.01 is not quite smooth.
        error = np.abs(f[:, channel] - expected)
        assert np.all(error < 0.01 * expected + 4 * se[:, channel])
        assert np.median(f[:, channel] / expected) == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("theta", [0.1, 0.6])
def test_walk_over_a_mirror_reaches_the_smooth_limit(theta: float) -> None:
    stack = coat(conductor(0.01, REFLECTANCE), 0.01, 1.5, albedo=0.0, sigma_t=SIGMA_T)
    wi = np.array([[np.sin(theta), 0.0, np.cos(theta)]])
    mean, se = (x[0] for x in albedo(stack, wi, walks=1 << 16, seed=3))
    for channel, (sigma_t, r0) in enumerate(zip(SIGMA_T, REFLECTANCE, strict=True)):
        expected = slab.mirror_albedo(np.cos(theta), 1.5, sigma_t, r0)
        # 1 %: light that GGX's tails reflect below the horizon is lost.
        assert abs(mean[channel] - expected) < 0.01 * expected + 3 * se[channel]
