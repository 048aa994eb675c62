"""Proposals, as of `core.mixture`, for arrays of NumPy."""

from typing import Any

import numpy as np

from urushi.core.mixture import Mixture
from urushi.core.namespace import NUMPY, components, stacked
from urushi.core.quadrature import half_vector_rule


def pdf(mixture: Any, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The density (...) of `sample` [1/sr] for directions (..., 3)."""
    return mixture.pdf(components(wi), components(wo), NUMPY)


def sample(mixture: Any, wi: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Directions (..., 3) of numbers u (..., 3), the first for the lobe."""
    choice, *others = components(u)
    return stacked(mixture.sample(components(wi), choice, others, NUMPY))


def weights(mixture: Mixture) -> np.ndarray:
    """The weights (..., K + 1)."""
    return np.stack(np.broadcast_arrays(*mixture.weights), axis=-1)


def variation(networks: Any, z: np.ndarray, f: Any, wi: np.ndarray) -> float:
    """Coefficient of variation of f cos / pdf, with the pdf of a code z (L,), by quadrature.

    Over directions wi (A, 3). A cosine lobe has up to 25.
    """
    wo, share = half_vector_rule(wi, anisotropic=networks.arch.widths == 2)
    f_cos = f(wi[:, None], wo) * wo[..., 2]
    density = pdf(networks.proposal(z, wi[:, None].astype(np.float32)), wi[:, None], wo)
    second = np.sum(f_cos**2 / density * share, axis=-1) / np.sum(f_cos * share, axis=-1) ** 2
    return np.sqrt(np.mean(second - 1))
