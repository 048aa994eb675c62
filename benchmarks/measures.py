"""Measures of any BRDF: E of its channels, and errors of coats; directions in a plane."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from benchmarks import brdf_errors

from urushi.mitsuba.reading import probing

#: f(wi, wo) -> (N, C) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


def in_plane(angles: npt.ArrayLike) -> np.ndarray:
    """Unit vectors float32 (N, 3) in the xz plane, by signed angles from the normal [rad]."""
    angles = np.asarray(angles, float)
    return np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1).astype(np.float32)


def channel_errors(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """E of each channel (C,), of values (N, C)."""
    return brdf_errors.stack_error(f_hat.T, f.T, wi[:, 2], wo[:, 2])


def error(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """E, the mean over channels that are not black, of values (N, C)."""
    lit = f.max(axis=0) > 0
    return float(channel_errors(f_hat[:, lit], f[:, lit], wi, wo).mean())


def coat_errors(
    f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> tuple[float, float]:
    """E, a mean over channels, and the relative error of the albedo under even light.

    Pairs have cosine density on both sides, so that albedos are plain means of values (N, C).
    """
    albedo = f_hat.mean(0, dtype=np.float64) / f.mean(0, dtype=np.float64) - 1
    return float(channel_errors(f_hat, f, wi, wo).mean()), float(albedo.mean())


def bsdf_values(bsdf: Any, wi: np.ndarray, wo: np.ndarray, number: Any = 0.0) -> np.ndarray:
    """f (N, 3) of a BSDF of Mitsuba; walks of a pair differ by their number, one or (N,)."""
    return probing.bsdf_values(bsdf, wi, wo, np.full((len(wi), 2), 0.5), number)
