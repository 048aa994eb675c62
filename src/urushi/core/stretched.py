"""Coordinates of pairs of directions for materials of two GGX widths.

A lobe of the widths a_u, a_v is round to the stretched half vector (h_x s, h_y / s, h_z) with
s = sqrt(a_v / a_u). The coordinates are therefore those of one width (`urushi.core.table`), with
the half angle of the stretched half vector. What is left of the azimuth is a sum over `FACTORS`:

    cos 2 psi, cos 2 p, cos 4 psi, cos 4 p, cos 2 psi cos 2 p

with psi the azimuth of the stretched half vector, and p that of wi - wo. All of them are the same
to the bit if wi and wo are exchanged, or both mirrored at the xz or the yz plane. They fade where
an azimuth means nothing, at the normal and between equal directions, so that f is continuous.
"""

from typing import Any

import numpy as np

from urushi.core.namespace import Namespace
from urushi.core.table import TAN2_OFFSET, Knots, coordinates, log_tangent

#: Number of factors of the azimuth.
FACTORS = 5

#: ln s is a multiple of this, so that codes share what depends on it alone; an error of s of ten
#: per cent does not matter. The largest |ln s| that is used.
STEP, LARGEST = 1 / 32, 1.25


def stretched(
    both: Any, apart: Any, stretch2: Any, xp: Namespace, knots: Knots = ()
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The coordinates (3) in [0, 1] up to rounding, and the factors (`FACTORS`).

    both, apart: components of wi + wo and of wi - wo. stretch2: s^2; 1 for one width.
    """
    x2, y2 = both.x * both.x * stretch2, both.y * both.y / stretch2
    z2 = xp.named("stretched_z2", xp.maximum(both.z * both.z, 1e-18))
    across = xp.named("stretched_across", x2 + y2)
    dx2, dy2 = apart.x * apart.x, apart.y * apart.y
    apart2 = xp.named("apart_across", dx2 + dy2)
    psi_size = xp.named("stretched_size", across + TAN2_OFFSET * z2)
    p_size = xp.named("apart_size", apart2 + 4 * TAN2_OFFSET)
    psi, psi_seen = xp.named("cos_2_psi", (x2 - y2) / psi_size), across / psi_size
    p, p_seen = xp.named("cos_2_p", (dx2 - dy2) / p_size), apart2 / p_size
    psi_seen, p_seen = xp.named("psi_seen", psi_seen), xp.named("p_seen", p_seen)
    _, v, w = coordinates(both, apart, xp, knots)
    u = log_tangent(across / z2, xp)
    return (u, v, w), (
        psi,
        p,
        2 * psi * psi - psi_seen * psi_seen,
        2 * p * p - p_seen * p_seen,
        psi * p,
    )


def rounded(log_stretch: Any) -> np.ndarray:
    """ln s as a multiple of `STEP`, at most `LARGEST`."""
    return np.clip(np.rint(np.asarray(log_stretch) / STEP) * STEP, -LARGEST, LARGEST)
