"""Screening of many codes: which of them may be too bright, by a regression.

Codes of a texture lie close together. A regression that is fitted to a thousand of them predicts
the albedo of the others.
"""

from collections.abc import Callable

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
        index = index[_candidates(excess, z[index] if seed else z, np.random.default_rng(seed))]
        if len(index) > before // 2 or len(index) < GAIN * SAMPLE:
            break
    return index


def _candidates(
    excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """`codes_to_measure` by one ridge regression of the logarithm of the excess.

    Its features are tanh of random combinations of a code's numbers, the numbers, and one.
    """
    sample, half = z[rng.integers(len(z), size=SAMPLE)], SAMPLE // 2
    target = np.log(excess(sample))
    mean, spread = sample.mean(axis=0), sample.std(axis=0)
    # Numbers that hardly vary must not be amplified.
    scale = 1 / np.maximum(spread, 0.01 * spread.max() + 1e-12)
    size = sample.shape[1]
    projection = (rng.normal(size=(size, FEATURES)) / np.sqrt(size)).astype(np.float32)
    shift = rng.uniform(-2, 2, FEATURES).astype(np.float32)
    reach = REACH * np.abs((sample - mean) * scale).max(axis=0) + 1e-3

    def features(x: np.ndarray) -> np.ndarray:
        one = np.ones((len(x), 1), np.float32)
        return np.concatenate([np.tanh(x @ projection + shift), x, one], axis=1)

    def estimate(z: np.ndarray) -> np.ndarray:  # infinite for codes far outside the sample
        x = (z - mean) * scale
        inside = (np.abs(x) <= reach).all(axis=-1)
        return np.where(inside, features(x) @ coefficients, np.float32(np.inf))[:, None]

    with one_blas_thread():  # the matrices are small
        x = features((sample[:half] - mean) * scale).astype(np.float64)
        weights = np.exp(WEIGHT_POWER * (target[:half] - target[:half].max()))
        weighted = x.T * (weights / weights.sum())
        normal = weighted @ x + RIDGE * np.eye(x.shape[1])
        coefficients = np.linalg.solve(normal, weighted @ target[:half]).astype(np.float32)
        errors = target[half:] - estimate(sample[half:])[:, 0]
    near = target[half:] >= min(-NEAR, np.quantile(target[half:], 0.9))
    margin = ERROR_FACTOR * max(float(errors[near].max()), 0) + LEAST_MARGIN
    values = np.empty((len(z), 1), np.float32)
    fill_blocks(values, estimate, z)
    return np.flatnonzero(values[:, 0] > -margin)
