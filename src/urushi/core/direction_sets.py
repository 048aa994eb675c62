"""Random sets of direction pairs, for the errors E and P and for the networks of Fan et al. (2022).

Every set is drawn in double precision from a generator that the caller seeds, and returned as
float32 unit vectors wi, wo of shape (n, 3), z the normal, both above the horizon.
"""

import functools
from collections.abc import Callable

import numpy as np

from urushi.core.directions import directions_at_tangent, turned

#: Range of tan(theta_h) for the error P.
HALF_ANGLE_RANGE = (1e-3, 4.0)

Pairs = tuple[np.ndarray, np.ndarray]


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

    return _accepted(draw, n, 0.0)


#: `half_angle_pairs` for anisotropic BRDFs.
slope_pairs = functools.partial(half_angle_pairs, slopes=True)


def cosine_pairs(rng: np.random.Generator, n: int, *, lowest_cosine: float = 0.0) -> Pairs:
    """Pairs of independent directions, both of density cos(theta) / pi, as for the error E."""

    def draw(count: int) -> Pairs:
        wi, wo = (_direction(np.sqrt(rng.random(count)), rng.random(count)) for _ in range(2))
        return wi, wo

    return _accepted(draw, n, lowest_cosine)


def stratified_pairs(rng: np.random.Generator, n: int) -> Pairs:
    """One pair in each of n = k^4 strata: k intervals for theta and phi of both directions.

    All four angles are uniform in their stratum (Fan et al. 2022, section 4.1), so that pairs are
    denser towards the normal than in solid angle.
    """
    k = round(n**0.25)
    cells = np.stack(np.unravel_index(np.arange(n), (k, k, k, k)))
    u = (cells + rng.random((4, n))) / k
    wi, wo = (_direction(np.cos(0.5 * np.pi * u[i]), u[i + 1]).astype(np.float32) for i in (0, 2))
    return wi, wo


def _accepted(draw: Callable[[int], Pairs], n: int, lowest_cosine: float) -> Pairs:
    """Draw until `n` pairs have both cosines above `lowest_cosine`, in the order drawn."""
    wi, wo = np.empty((0, 3), np.float32), np.empty((0, 3), np.float32)
    while len(wi) < n:
        new_wi, new_wo = (direction.astype(np.float32) for direction in draw(n))
        keep = np.minimum(new_wi[:, 2], new_wo[:, 2]) > lowest_cosine
        wi, wo = np.concatenate([wi, new_wi[keep]]), np.concatenate([wo, new_wo[keep]])
    return wi[:n], wo[:n]


def _direction(cosine: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) of the given cosine, at azimuth 2 pi u."""
    sine = np.sqrt(np.maximum(0.0, 1 - cosine * cosine))
    return np.stack([sine * np.cos(2 * np.pi * u), sine * np.sin(2 * np.pi * u), cosine], -1)
