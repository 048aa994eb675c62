"""Screening of many codes: which of them may be too bright, by a regression.

Codes of a texture lie close together. A regression that is fitted to a thousand of them predicts
the albedo of the others.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.parallel import fill_blocks, one_blas_thread

#: Number of codes that are measured, half to fit the regression and half to estimate its error.
SAMPLE = 1024

#: Codes are weighted in the fit by this power of their excess. The error of the regression is its
#: greatest error over held-out codes whose ln excess is above -`NEAR`, or over the brightest tenth,
#: times `ERROR_FACTOR`, plus `LEAST_MARGIN`.
WEIGHT_POWER, NEAR, ERROR_FACTOR, LEAST_MARGIN = 4.0, 0.25, 2.0, 0.02

#: Regression: number of random features, and ridge.
FEATURES, RIDGE = 64, 1e-3

#: Factor on the range of the sample; a code outside this range in any number is measured.
REACH = 1.25

#: Greatest number of rounds, each with its own sample. The rounds stop when fewer than
#: `GAIN` times `SAMPLE` candidates remain.
ROUNDS, GAIN = 4, 4


def codes_to_measure(excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray) -> np.ndarray:
    """Indices of the codes among z (N, L) whose excess may be greater than one.

    excess: measures the positive excess (n,) of codes (n, L). Samples have fixed seeds.

    The candidates are screened again in further rounds, because a regression on bright codes alone
    is more exact.
    """
    index = np.arange(len(z))
    for seed in range(ROUNDS):
        before = len(index)
        index = index[_codes_to_measure(excess, z[index] if seed else z, seed)]
        if len(index) > before // 2 or len(index) < GAIN * SAMPLE:
            break
    return index


def _codes_to_measure(
    excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray, seed: int
) -> np.ndarray:
    rng = np.random.default_rng(seed)
    sample = z[rng.integers(len(z), size=SAMPLE)]
    target = np.log(excess(sample))
    half = SAMPLE // 2
    with one_blas_thread():  # the matrices are small
        estimate = AlbedoRegression.fit(sample[:half], target[:half], sample, rng)
        errors = target[half:] - estimate(sample[half:])
    near = target[half:] >= min(-NEAR, np.quantile(target[half:], 0.9))
    margin = ERROR_FACTOR * max(float(errors[near].max()), 0) + LEAST_MARGIN
    values = np.empty((len(z), 1), np.float32)
    fill_blocks(values, lambda codes: estimate(codes)[:, None], z)
    return np.flatnonzero(values[:, 0] > -margin)


class AlbedoRegression(NamedTuple):
    """Ridge regression of the logarithm of the excess of codes.

    Its features are tanh of random combinations of a code's numbers, the numbers, and one.

    Attributes:
        mean, scale: (L,) of the numbers, by which they are standardised.
        projection, shift: (L, K) and (K,) of the random combinations of standardised numbers.
        reach: (L,) magnitudes up to which the sample has standardised numbers.
        coefficients: (F,) of the features.
    """

    mean: np.ndarray
    scale: np.ndarray
    projection: np.ndarray
    shift: np.ndarray
    reach: np.ndarray
    coefficients: np.ndarray

    @classmethod
    def fit(
        cls, z: np.ndarray, target: np.ndarray, sample: np.ndarray, rng: np.random.Generator
    ) -> "AlbedoRegression":
        """Fit targets (n,) of codes z (n, L); sample: codes that define the range."""
        size = sample.shape[1]
        mean, spread = sample.mean(axis=0), sample.std(axis=0)
        # Numbers that hardly vary must not be amplified.
        scale = 1 / np.maximum(spread, 0.01 * spread.max() + 1e-12)
        projection = (rng.normal(size=(size, FEATURES)) / np.sqrt(size)).astype(np.float32)
        shift = rng.uniform(-2, 2, FEATURES).astype(np.float32)
        reach = REACH * np.abs((sample - mean) * scale).max(axis=0) + 1e-3
        unfitted = cls(mean, scale, projection, shift, reach, np.zeros(0))
        x = unfitted.features((z - mean) * scale).astype(np.float64)
        weights = np.exp(WEIGHT_POWER * (target - target.max()))
        weighted = x.T * (weights / weights.sum())
        normal = weighted @ x + RIDGE * np.eye(x.shape[1])
        return unfitted._replace(
            coefficients=np.linalg.solve(normal, weighted @ target).astype(np.float32)
        )

    def features(self, x: np.ndarray) -> np.ndarray:
        """Features (N, F) of standardised codes (N, L)."""
        one = np.ones((len(x), 1), np.float32)
        return np.concatenate([np.tanh(x @ self.projection + self.shift), x, one], axis=1)

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Estimates (N,) for codes (N, L); infinite for those far outside the sample."""
        x = (z - self.mean) * self.scale
        inside = (np.abs(x) <= self.reach).all(axis=-1)
        return np.where(inside, self.features(x) @ self.coefficients, np.float32(np.inf))
