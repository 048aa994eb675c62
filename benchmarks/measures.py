"""Measures of any BRDF: E of its channels and directional albedos; directions in a plane."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from urushi.core import error_metrics
from urushi.core.quadrature import half_vector_rule

#: f(wi, wo) -> (N, C) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


def in_plane(angles: npt.ArrayLike) -> np.ndarray:
    """Unit vectors float32 (N, 3) in the xz plane, by signed angles from the normal [rad]."""
    angles = np.asarray(angles, float)
    return np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1).astype(np.float32)


def channel_errors(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """E of each channel (C,), of values (N, C)."""
    return error_metrics.stack_error(f_hat.T, f.T, wi[:, 2], wo[:, 2])


def error(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """E, the mean over channels that are not black, of values (N, C)."""
    lit = f.max(axis=0) > 0
    return float(channel_errors(f_hat[:, lit], f[:, lit], wi, wo).mean())


def albedos(f: Brdf, wi: np.ndarray, *, anisotropic: bool = False) -> np.ndarray:
    """Directional albedos (N, C) of a BRDF for wi (N, 3) above the horizon."""
    wo, weights = half_vector_rule(wi, anisotropic=anisotropic)
    each = np.repeat(wi, weights.shape[1], axis=0).astype(np.float32)
    values = f(each, wo.reshape(-1, 3).astype(np.float32)).reshape(*weights.shape, -1)
    return np.einsum("inc,in->ic", values, weights * wo[..., 2])
