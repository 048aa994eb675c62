"""Tables of BRDFs over half and difference angles: MERL's layout, of any resolution.

Bin i of n along theta_h spans [i, i + 1) of n sqrt(theta_h / 90 deg); along theta_d and phi_d bins
are equal parts of 90 and 180 degrees. A bin's value belongs to its centre.
"""

from collections.abc import Callable

import numpy as np

from urushi.measured.fill import fill_nearest
from urushi.measured.rusinkiewicz import above_horizon, directions, half_difference_angles

#: Bins along theta_h, theta_d and phi_d.
Shape = tuple[int, int, int]


def bin_centres(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """theta_h (H, 1, 1), theta_d (1, D, 1) and phi_d (1, 1, P) of the bins' centres [rad]."""
    half, difference, turn = ((np.arange(n) + 0.5) / n for n in shape)
    return (
        (half**2 * (np.pi / 2))[:, None, None],
        (difference * (np.pi / 2))[None, :, None],
        (turn * np.pi)[None, None, :],
    )


def interpolated(table: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Values (N, C) of a table (H, D, P, C) at directions float64 (N, 3) above the horizon.

    Trilinear between bin centres, along sqrt(theta_h), theta_d and phi_d. phi_d is periodic over
    180 degrees, as reciprocity demands. Before the first centre of theta_h and theta_d the first
    bin holds, beyond the last one the last.
    """
    shape, rows = table.shape[:3], table.reshape(-1, table.shape[3])
    theta_h, theta_d, phi_d = half_difference_angles(wi, wo)
    half = _between_centres(np.sqrt(theta_h / (np.pi / 2)), shape[0])
    difference = _between_centres(theta_d / (np.pi / 2), shape[1])
    turn = _between_centres(phi_d / np.pi, shape[2], periodic=True)
    result = np.zeros((len(wi), table.shape[3]))
    for i, weight_i in half:
        for j, weight_j in difference:
            for k, weight_k in turn:
                weight = weight_i * weight_j * weight_k
                bins = (i * shape[1] + j) * shape[2] + k
                result += weight[:, None] * rows[bins]
    return result


def tabulated(f: Callable[[np.ndarray, np.ndarray], np.ndarray], shape: Shape) -> np.ndarray:
    """The table float32 (H, D, P, C) of a BRDF f(wi, wo) -> (N, C), averaged over the exchange.

    What has a direction below the horizon is filled as of `fill_nearest`.
    """
    angles = bin_centres(shape)
    above = above_horizon(*angles)
    angles_above = (angle[above] for angle in np.broadcast_arrays(*angles))
    wi, wo = (w.astype(np.float32) for w in directions(*angles_above))
    values = 0.5 * (f(wi, wo) + f(wo, wi))
    table = np.zeros((*above.shape, values.shape[1]), np.float32)
    table[above] = values
    fill_nearest(table, above)
    return table


def _between_centres(
    u: np.ndarray, bins: int, *, periodic: bool = False
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the two bins whose centres enclose u in [0, 1], each with its weight."""
    position = u * bins - 0.5
    if not periodic:
        position = np.clip(position, 0, bins - 1)
    lower = np.floor(position).astype(np.intp)
    weight = position - lower
    upper = lower + 1
    if periodic:
        lower, upper = lower % bins, upper % bins
    else:
        upper = np.minimum(upper, bins - 1)
    return [(lower, 1 - weight), (upper, weight)]
