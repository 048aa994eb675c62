"""Stratified pairs of directions, by which the paper's networks are trained."""

import numpy as np

from urushi.core.direction_sets import Pairs, direction


def stratified_pairs(rng: np.random.Generator, n: int) -> Pairs:
    """One pair in each of n = k^4 strata: k intervals for theta and phi of both directions.

    All four angles are uniform in their stratum (Fan et al. 2022, section 4.1), so that pairs are
    denser towards the normal than in solid angle.
    """
    k = round(n**0.25)
    cells = np.stack(np.unravel_index(np.arange(n), (k, k, k, k)))
    u = (cells + rng.random((4, n))) / k
    wi, wo = (direction(np.cos(0.5 * np.pi * u[i]), u[i + 1]).astype(np.float32) for i in (0, 2))
    return wi, wo
