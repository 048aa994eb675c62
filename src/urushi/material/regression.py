"""Regression of an albedo's logarithm on codes: linear, and by tanh of random combinations."""

from typing import NamedTuple

import numpy as np

#: Random features besides the codes themselves.
FEATURES = 64

_RIDGE = 1e-3


class Estimate(NamedTuple):
    """ln albedo, linear in a code's numbers and in tanh of random combinations of them."""

    mean: np.ndarray
    scale: np.ndarray
    reach: np.ndarray
    projection: np.ndarray
    shift: np.ndarray
    coefficients: np.ndarray

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Estimates (N,) for codes (N, 32); infinite for those far outside the sample."""
        x = (z - self.mean) * self.scale
        inside = (np.abs(x) <= self.reach).all(axis=-1)
        return np.where(inside, self.features(x) @ self.coefficients, np.float32(np.inf))

    def features(self, x: np.ndarray) -> np.ndarray:
        """Features (N, F) of standardised codes (N, 32)."""
        one = np.ones((len(x), 1), np.float32)
        return np.concatenate([np.tanh(x @ self.projection + self.shift), x, one], axis=1)


def standard(codes: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Mean and inverse spread (K,) of codes (n, K); spreads below `least` are no variation."""
    mean, spread = codes.mean(axis=0), codes.std(axis=0)
    # Numbers that hardly vary must not count as if they did.
    return mean, 1 / np.maximum(spread, 0.01 * spread.max() + least)


def fitted(
    codes: np.ndarray,
    target: np.ndarray,
    weights: np.ndarray,
    mean: np.ndarray,
    scale: np.ndarray,
    reach: np.ndarray,
    rng: np.random.Generator,
) -> Estimate:
    """Ridge regression of targets (n,) of some weights (n,) on codes (n, K).

    mean, scale (K,): as of `standard`; reach (K,): how far it may be used, in these units.
    """
    size = codes.shape[1]
    projection = (rng.normal(size=(size, FEATURES)) / np.sqrt(size)).astype(np.float32)
    shift = rng.uniform(-2, 2, FEATURES).astype(np.float32)
    bare = Estimate(mean, scale, reach, projection, shift, np.zeros(0, np.float32))
    x = bare.features((codes - mean) * scale).astype(np.float64)
    weighted = x.T * (weights / weights.sum())
    coefficients = np.linalg.solve(weighted @ x + _RIDGE * np.eye(x.shape[1]), weighted @ target)
    return bare._replace(coefficients=coefficients.astype(np.float32))
