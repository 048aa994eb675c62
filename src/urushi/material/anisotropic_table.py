"""Coordinates of tables over directions for BRDFs of two GGX widths; see `material.table`.

A BRDF that is symmetric about the xz and the yz plane has four coordinates in [0, 1]:

    u_x = (ln(h_x^2 / h_z^2 + `TAN2_OFFSET`) - `LOWEST`) / (`HIGHEST` - `LOWEST`), u_y likewise
    v   = sqrt(1 - cos theta_d)
    p   = the angle in the xy plane between the x axis and wi - wo, over pi

with the half vector h and the difference angle theta_d of Rusinkiewicz (1998). The signs of x and y
are chosen so that h_x and h_y are not negative. The angle is that of a square, not of a circle:
|y| / (|x| + |y|) stands for it in the first quadrant, which costs one division. wi - wo and wo - wi
have the same angle. Exchanging wi and wo, and mirroring both, leave the coordinates the same to
the bit.
"""

import math

import numpy as np

#: Nodes in u_x, u_y, v and p.
SHAPE = (40, 40, 16, 20)

#: Of the coordinates u_x and u_y.
TAN2_OFFSET = 1e-5
LOWEST, HIGHEST = math.log(TAN2_OFFSET), math.log(1e2)


def coordinates(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, ...]:
    """The coordinates u_x, u_y, v, p (N,) of pairs (N, 3), in [0, 1] up to rounding.

    u_x and u_y exceed one where h is less than 6 degrees above the horizon.
    """
    x, y, z = ((wi[:, i] + wo[:, i]).astype(np.float64) for i in range(3))
    dx, dy = ((wi[:, i] - wo[:, i]).astype(np.float64) for i in range(2))
    x2, y2, z2 = x * x, y * y, np.maximum(z * z, 1e-18)
    scale = 1 / (HIGHEST - LOWEST)
    along, across = ((np.log(c / z2 + TAN2_OFFSET) - LOWEST) * scale for c in (x2, y2))
    cos_d = np.minimum(0.5 * np.sqrt(x2 + y2 + z2), 1)
    turned = 0.5 * np.abs(dy) / np.maximum(np.abs(dx) + np.abs(dy), 1e-12)
    angle = np.where((x * y) * (dx * dy) < 0, 1 - turned, turned)
    return along, across, np.sqrt(1 - cos_d), angle


def node_directions(
    u_x: np.ndarray, u_y: np.ndarray, v: np.ndarray, p: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A pair wi, wo float32 (N, 3) with the coordinates (N,).

    Some coordinates belong to a pair of which one direction is below the horizon.
    """
    tangents = [
        np.sqrt(np.maximum(np.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET, 0))
        for u in (u_x, u_y)
    ]
    h = _unit(np.stack([*tangents, np.ones_like(v)], axis=-1))
    share = np.minimum(2 * p, 2 - 2 * p)
    dx, dy = np.where(p > 0.5, share - 1, 1 - share), share
    dz = -(h[:, 0] * dx + h[:, 1] * dy) / h[:, 2]
    cos_d = 1 - v * v
    sin_d = np.sqrt(np.maximum(1 - cos_d * cos_d, 0))
    along = h * cos_d[:, None]
    across = _unit(np.stack([dx, dy, dz], axis=-1)) * sin_d[:, None]
    return (along + across).astype(np.float32), (along - across).astype(np.float32)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
