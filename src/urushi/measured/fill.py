"""Filling of a MERL table's invalid bins from their nearest valid neighbours."""

import numpy as np


def fill_nearest(values: np.ndarray, valid: np.ndarray) -> None:
    """Overwrite invalid bins, in place.

    Each takes the nearest valid bin of its row along theta_d or along phi_d (periodic), whichever
    is fewer bins away (phi_d, if equal: it keeps the Fresnel term). What has neither takes part in
    another round, as soon as its neighbours are filled; slices of theta_h without any valid bin
    take the nearest slice.

    Args:
        values: (theta_h, theta_d, phi_d, channels).
        valid: bool, the first three of these axes; at least one is true.
    """
    for slice_values, slice_valid in zip(values, valid, strict=True):
        known = slice_valid.copy()
        while known.any() and not known.all():
            _fill_once(slice_values, known)
    empty = ~valid.any(axis=(1, 2))
    if empty.any():
        filled = np.flatnonzero(~empty)
        for i in np.flatnonzero(empty):
            values[i] = values[filled[np.argmin(np.abs(filled - i))]]


def _fill_once(values: np.ndarray, known: np.ndarray) -> None:
    """Fill what has a known bin in its row or column of (theta_d, phi_d); mark it as known."""
    count = known.shape[1]
    in_column, column_distance = _nearest(known)
    wrapped, row_distance = _nearest(np.tile(known, (1, 3)).T)  # three turns: periodic
    in_row = wrapped.T[:, count : 2 * count] % count
    row_distance = row_distance.T[:, count : 2 * count]
    by_row = row_distance <= column_distance
    found = ~known & np.isfinite(np.minimum(row_distance, column_distance))
    j, k = np.nonzero(found)
    source_j = np.where(by_row[j, k], j, in_column[j, k])
    source_k = np.where(by_row[j, k], in_row[j, k], k)
    values[j, k] = values[source_j, source_k]
    known[j, k] = True


def _nearest(known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Along axis 0: the nearest known entry's index and its distance (infinite: there is none)."""
    count = len(known)
    index = np.broadcast_to(np.arange(count)[:, None], known.shape)
    before = np.maximum.accumulate(np.where(known, index, -3 * count), axis=0)
    after = np.minimum.accumulate(np.where(known, index, 3 * count)[::-1], axis=0)[::-1]
    nearest = np.where(index - before <= after - index, before, after)
    distance = np.abs(nearest - index).astype(np.float64)
    missing = distance > count
    return np.where(missing, 0, nearest), np.where(missing, np.inf, distance)
