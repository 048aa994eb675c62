"""Which of very many codes may be too bright, from measuring a few of them.

A texture has millions of codes, and to measure one costs some hundred evaluations of the decoder.
But they lie close together: a regression on a thousand of them tells the others' albedo well enough
to leave out those that are far from the ceiling.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.material import regression
from urushi.material.cores import fill
from urushi.material.regression import Features

#: Codes that are measured, half of them to fit the regression and half to see its errors.
SAMPLE = 1024

#: The brighter a code, the more its error counts: weights are this power of the albedo. Of the
#: held-out ones those within `NEAR` of the ceiling in ln albedo, and in any case the brightest
#: tenth, tell the error, which is trusted up to a factor and a constant.
POWER, NEAR, TRUST, LEAST_MARGIN = 4.0, 0.25, 2.0, 0.02

#: Of the regression: random features besides the codes themselves, and its ridge.
FEATURES, RIDGE = 64, 1e-3

#: A code that is this much farther out than all of the sample, in any number, is no matter of
#: interpolation and is measured.
OUTSIDE = 1.25

#: Rounds at most, each with a sample of its own, which must be worth it: suspects for each code
#: that is measured.
ROUNDS, WORTH = 4, 4


def suspects(peak: Callable[[np.ndarray], np.ndarray], z: np.ndarray, ceiling: float) -> np.ndarray:
    """Indices of the codes among z (N, 32) whose largest albedo may exceed a ceiling.

    peak: measures the largest albedo (n,), positive, of codes (n, 32). Samples have fixed seeds.

    What remains is looked at again, for as long as that pays: among codes that are all bright, a
    regression is more exact.
    """
    index = np.arange(len(z))
    for seed in range(ROUNDS):
        before = len(index)
        index = index[_suspects(peak, z[index] if seed else z, ceiling, seed)]
        if len(index) > before // 2 or len(index) < WORTH * SAMPLE:
            break
    return index


def _suspects(
    peak: Callable[[np.ndarray], np.ndarray], z: np.ndarray, ceiling: float, seed: int
) -> np.ndarray:
    rng = np.random.default_rng(seed)
    sample = z[rng.integers(len(z), size=SAMPLE)]
    target = np.log(peak(sample)) - np.log(ceiling)
    half = SAMPLE // 2
    estimate = _fitted(sample[:half], target[:half], sample, rng)
    errors = target[half:] - estimate(sample[half:])
    near = target[half:] >= min(-NEAR, np.quantile(target[half:], 0.9))
    margin = TRUST * max(float(errors[near].max()), 0) + LEAST_MARGIN
    values = np.empty((len(z), 1), np.float32)
    fill(values, lambda codes: estimate(codes)[:, None], z)
    return np.flatnonzero(values[:, 0] > -margin)


class Estimate(NamedTuple):
    """ln albedo of codes, as far as a sample reaches."""

    features: Features
    reach: np.ndarray
    coefficients: np.ndarray

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Estimates (N,) for codes (N, 32); infinite for those far outside the sample."""
        x = self.features.standard(z)
        inside = (np.abs(x) <= self.reach).all(axis=-1)
        return np.where(
            inside, self.features.of_standard(x) @ self.coefficients, np.float32(np.inf)
        )


def _fitted(
    z: np.ndarray, target: np.ndarray, sample: np.ndarray, rng: np.random.Generator
) -> Estimate:
    """An estimate from targets (n,) of codes (n, 32), for use as far as the sample reaches."""
    features = regression.features(sample, FEATURES, 1e-12, rng)
    reach = OUTSIDE * np.abs(features.standard(sample)).max(axis=0) + 1e-3
    weights = np.exp(POWER * (target - target.max()))
    return Estimate(features, reach, regression.coefficients(features(z), target, RIDGE, weights))
