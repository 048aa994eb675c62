"""Proposals, as of `core.mixture`, for arrays of NumPy."""

from typing import Any

import numpy as np

from urushi.core.mixture import Mixture
from urushi.core.namespace import NUMPY, components, stacked_components


def pdf(mixture: Any, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The density (...) of `sample` [1/sr] for directions (..., 3)."""
    return mixture.pdf(components(wi), components(wo), NUMPY)


def sample(mixture: Any, wi: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Directions (..., 3) of numbers u (..., 3), the first for the lobe."""
    choice, *others = components(u)
    return stacked_components(mixture.sample(components(wi), choice, others, NUMPY), np)


def weights(mixture: Mixture) -> np.ndarray:
    """The weights (..., K + 1)."""
    return np.stack(np.broadcast_arrays(*mixture.weights), axis=-1)
