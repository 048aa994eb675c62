"""Ridge regression on codes, linear and by tanh of random combinations of their numbers."""

from typing import NamedTuple

import numpy as np


class CodeFeatures(NamedTuple):
    """Features of codes: tanh of random combinations, the standardised numbers, and one."""

    mean: np.ndarray
    scale: np.ndarray
    projection: np.ndarray
    shift: np.ndarray

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Features (N, F) of codes (N, K)."""
        return self.of_standard(self.standard(z))

    def standard(self, z: np.ndarray) -> np.ndarray:
        """Codes (N, K) in units of the sample's spread."""
        return (z - self.mean) * self.scale

    def of_standard(self, x: np.ndarray) -> np.ndarray:
        """Features (N, F) of standardised codes (N, K)."""
        one = np.ones((len(x), 1), np.float32)
        return np.concatenate([np.tanh(x @ self.projection + self.shift), x, one], axis=1)


def fit_features(
    codes: np.ndarray, count: int, least: float, rng: np.random.Generator
) -> CodeFeatures:
    """Features for codes like those of a sample (n, K).

    count: number of combinations; least: spread below which a number counts as constant.
    """
    size = codes.shape[1]
    mean, spread = codes.mean(axis=0), codes.std(axis=0)
    # Numbers that hardly vary must not be amplified.
    scale = 1 / np.maximum(spread, 0.01 * spread.max() + least)
    projection = (rng.normal(size=(size, count)) / np.sqrt(size)).astype(np.float32)
    return CodeFeatures(mean, scale, projection, rng.uniform(-2, 2, count).astype(np.float32))


def ridge_coefficients(
    x: np.ndarray, target: np.ndarray, ridge: float, weights: np.ndarray | None = None
) -> np.ndarray:
    """Ridge regression: float32 (F,) or (F, T) for features x (n, F) and targets (n,) or (n, T).

    weights: (n,), equal by default.
    """
    x = x.astype(np.float64)
    share = np.full(len(x), 1 / len(x)) if weights is None else weights / weights.sum()
    weighted = x.T * share
    normal = weighted @ x + ridge * np.eye(x.shape[1])
    return np.linalg.solve(normal, weighted @ target).astype(np.float32)
