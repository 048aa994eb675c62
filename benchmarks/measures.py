"""Measures of BRDFs: the errors E and P, the pairs of P, and errors of coats."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core import error_metrics
from urushi.core.direction_sets import Pairs, accepted
from urushi.core.directions import directions_at_tangent, turned
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing

#: f(wi, wo) -> (N, C) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]

#: [1/sr] Added to f in P and before logarithms are compared: values far below it look black, and
#: measured colours outside of sRGB have channels that are zero.
DARK_OFFSET = 1e-3


def stack_error(
    f_hat: npt.ArrayLike, f: npt.ArrayLike, cos_i: npt.ArrayLike, cos_o: npt.ArrayLike
) -> np.ndarray:
    """E = sum |f_hat - f| cos_i cos_o / sum f cos_i cos_o: the error of the reflected energy.

    Args:
        f_hat: (..., M) values to judge [1/sr], without cosine, at M pairs of directions drawn
            with cosine density on both sides.
        f: (..., M) reference values [1/sr]; no row may be zero throughout.
        cos_i, cos_o: (..., M) cosines of the pairs to the normal; clamped to `COSINE_FLOOR`.

    Returns:
        (...) float64: 0 for exact values, 1 for an error as large as the reflected energy.

    Raises:
        ParameterError: a value is not finite, a shape does not fit, or a reference is black.
    """
    f_hat, f, cos_i, cos_o = checks.finite(f_hat=f_hat, f=f, cos_i=cos_i, cos_o=cos_o)
    weight = error_metrics.energy_weight(cos_i, cos_o)
    energy = (f * weight).sum(-1)
    if (energy <= 0).any():
        raise ParameterError(
            "f reflects no energy in at least one stack, where E is undefined; leave that stack out"
        )
    return (np.abs(f_hat - f) * weight).sum(-1) / energy


def pair_error(f_hat: npt.ArrayLike, f: npt.ArrayLike) -> np.ndarray:
    """P = |f_hat - f| / (f + 0.001): the relative error of a pair in peaks and tails.

    Args:
        f_hat, f: (...) values to judge and reference values [1/sr], at pairs whose tangent of the
            half angle is log-uniform in [0.001, 4].

    Returns:
        (...) float64.
    """
    f_hat, f = checks.finite(f_hat=f_hat, f=f)
    return np.abs(f_hat - f) / (f + DARK_OFFSET)


#: Range of tan(theta_h) for the error P.
HALF_ANGLE_RANGE = (1e-3, 4.0)


def half_angle_pairs(rng: np.random.Generator, n: int, *, slopes: bool = False) -> Pairs:
    """Pairs with ln tan(theta_h) uniform about difference directions over the whole hemisphere.

    The half vector h lies in the xz plane, tan(theta_h) log-uniform in `HALF_ANGLE_RANGE`; about it
    wi has the difference angles theta_d uniform in [0, pi/2) and phi_d uniform (Rusinkiewicz 1998);
    wo is the mirror image of wi about h. Pairs below the horizon are drawn again, so that the
    accepted pairs have this density, cut off there.

    slopes: whether half vectors have every azimuth, for anisotropic BRDFs. It is uniform for half
        of the pairs. The half vectors of the others have independent slopes h_x / h_z and
        h_y / h_z, log-uniform in this range, so that there are pairs near both axes of a lobe
        whatever its two widths are.
    """
    low, high = np.log(HALF_ANGLE_RANGE)

    def draw(count: int) -> Pairs:
        u = rng.random((5 if slopes else 3, count))
        tangent, turn = np.exp(low + (high - low) * u[0]), np.zeros(count)
        if slopes:
            across = np.exp(low + (high - low) * u[3])
            radial = u[4] < 0.5
            turn = np.where(radial, 2 * np.pi * u[3], np.arctan2(across, tangent))
            turn += np.where(radial, 0.0, 0.5 * np.pi * np.floor(8 * (u[4] - 0.5)))
            tangent = np.where(radial, tangent, np.hypot(tangent, across))
        wi, wo = directions_at_tangent(tangent, 0.5 * np.pi * u[1], 2 * np.pi * u[2])
        return (turned(wi, turn), turned(wo, turn)) if slopes else (wi, wo)

    return accepted(draw, n, 0.0)


def in_plane(angles: npt.ArrayLike) -> np.ndarray:
    """Unit vectors float32 (N, 3) in the xz plane, by signed angles from the normal [rad]."""
    angles = np.asarray(angles, float)
    return np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1).astype(np.float32)


def channel_errors(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """E of each channel (C,), of values (N, C)."""
    return stack_error(f_hat.T, f.T, wi[:, 2], wo[:, 2])


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


def moved(f: np.ndarray, se: np.ndarray) -> np.ndarray:
    """Values moved by their noise: the mean size of a normal error is 0.8 of its deviation."""
    return f + np.sqrt(2 / np.pi) * se


def bsdf_values(bsdf: Any, wi: np.ndarray, wo: np.ndarray, number: Any = 0.0) -> np.ndarray:
    """f (N, 3) of a BSDF of Mitsuba; walks of a pair differ by their number, one or (N,)."""
    return probing.bsdf_values(bsdf, wi, wo, np.full((len(wi), 2), 0.5), number)
