"""Measured BRDFs as surfaces: evaluation of directions, and tables over half and difference angles.

A table has MERL's layout at any resolution (H, D, P). Bin i along theta_h spans [i, i + 1) of
H sqrt(theta_h / 90 deg). Along theta_d and phi_d, bins are equal parts of 90 and 180 degrees. The
value of a bin belongs to its centre.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core.directions import above_horizon, directions_at, half_difference
from urushi.core.namespace import NUMPY, components
from urushi.parallel import fill_blocks
from urushi.walk.tabulated import Tabulated

#: Numbers of bins along theta_h, theta_d and phi_d.
Shape = tuple[int, int, int]

#: Numbers that a core looks up at once: its work on them about fills its cache.
NUMBERS = 1 << 15

#: Largest value that float32 results hold.
_LARGEST = float(np.finfo(np.float32).max)


class MeasuredSurface(ABC):
    """A measured BRDF, which can also be the bottom of a stack.

    `f` evaluates it. Under a coat, as in `urushi.coat(urushi.load_measured(path))`, the random
    walk uses `table` instead.
    """

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate in linear sRGB.

        Args:
            wi, wo: (N, 3) unit vectors; wi is the direction of the light in the measurement.

        Returns:
            float32 (N, 3): [1/sr], without cosine, never negative; 0 below the horizon.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return np.maximum(evaluate(self._lookup, 3, wi, wo), 0)

    @abstractmethod
    def _lookup(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (N, 3) of `evaluate`."""

    @abstractmethod
    def table(self) -> np.ndarray:
        """The BRDF made reciprocal, as a table float32 (H, D, P, 3) [1/sr]."""

    @cached_property
    def tabulated(self) -> Tabulated:
        """The table as a bottom of the random walk."""
        return Tabulated(self.table())

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """See `urushi.walk.bottoms.bottom.Bottom`."""
        return self.tabulated.f_pdf(wi, wo)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        """See `urushi.walk.bottoms.bottom.Bottom`."""
        return self.tabulated.sample(wi, u0, u1, u2)


def evaluate(
    lookup: Callable[[np.ndarray, np.ndarray], np.ndarray],
    channels: int,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike,
) -> np.ndarray:
    """Evaluate a BRDF at pairs on all cores; zero where a direction is not above the horizon.

    Args:
        lookup: maps exact unit vectors wi, wo, float64 (M, 3), to finite values (M, channels).
        channels: number of values per pair.
        wi, wo: (N, 3) unit vectors.

    Returns:
        float32 (N, channels).
    """
    wi, wo = checks.directions(wi, wo)
    result = np.zeros((len(wi), channels), np.float32)
    above = np.flatnonzero((wi[:, 2] > 0) & (wo[:, 2] > 0))

    def values(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.clip(lookup(_unit(wi), _unit(wo)), -_LARGEST, _LARGEST)

    found = np.empty((len(above), channels), np.float32)
    rows = max(1, NUMBERS // channels)
    result[above] = fill_blocks(found, values, wi[above], wo[above], rows=rows)
    return result


def _unit(w: np.ndarray) -> np.ndarray:
    """Directions (N, 3) as float64, normalised."""
    w = w.astype(np.float64)
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def bin_centres(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return theta_h (H, 1, 1), theta_d (1, D, 1), phi_d (1, 1, P) of the bins' centres [rad]."""
    half, difference, turn = ((np.arange(n) + 0.5) / n for n in shape)
    return (
        (half**2 * (np.pi / 2))[:, None, None],
        (difference * (np.pi / 2))[None, :, None],
        (turn * np.pi)[None, None, :],
    )


def interpolated(table: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Return values (N, C) of a table (H, D, P, C) at float64 (N, 3) directions above the horizon.

    Interpolation is trilinear between bin centres, along sqrt(theta_h), theta_d and phi_d. phi_d
    is periodic over 180 degrees, as reciprocity requires. Below the first centre of theta_h and
    theta_d the first bin's value is used, above the last centre the last bin's.
    """
    shape, rows = table.shape[:3], table.reshape(-1, table.shape[3])
    theta_h, theta_d, phi_d = half_difference(components(wi), components(wo), NUMPY)
    places = np.sqrt(theta_h / (np.pi / 2)), theta_d / (np.pi / 2), phi_d / np.pi
    positions = [place * bins - 0.5 for place, bins in zip(places, shape, strict=True)]
    positions[:2] = (np.clip(x, 0, n - 1) for x, n in zip(positions, shape[:2], strict=False))
    lower = [np.floor(position).astype(np.intp) for position in positions]
    shares = [position - low for position, low in zip(positions, lower, strict=True)]
    result = np.zeros((len(wi), table.shape[3]))
    for corner in np.ndindex(2, 2, 2):
        i, j, k = (low + step for low, step in zip(lower, corner, strict=True))
        bins = np.ravel_multi_index((i, j, k), shape, ("clip", "clip", "wrap"))
        weight = math.prod(x if step else 1 - x for x, step in zip(shares, corner, strict=True))
        result += weight[:, None] * rows[bins]
    return result


def tabulated(f: Callable[[np.ndarray, np.ndarray], np.ndarray], shape: Shape) -> np.ndarray:
    """Return the table float32 (H, D, P, C) of a BRDF f(wi, wo) -> (N, C).

    Each value is the mean over the exchange of wi and wo. Bins with a direction below the horizon
    are filled by `fill_nearest`.
    """
    angles = bin_centres(shape)
    above = above_horizon(*angles)
    angles_above = (angle[above] for angle in np.broadcast_arrays(*angles))
    wi, wo = (w.astype(np.float32) for w in directions_at(*angles_above))
    values = 0.5 * (f(wi, wo) + f(wo, wi))
    table = np.zeros((*above.shape, values.shape[1]), np.float32)
    table[above] = values
    fill_nearest(table, above)
    return table


def fill_nearest(values: np.ndarray, valid: np.ndarray) -> None:
    """Overwrite invalid bins in place with values of nearby valid ones.

    An invalid bin takes the nearest valid value along theta_d or along phi_d (periodic), whichever
    is fewer bins away; phi_d if they are equally far, because that keeps the Fresnel term. Bins
    with neither are filled in a further round, from the bins just filled. A slice of theta_h
    without valid bins takes the nearest filled slice.

    Args:
        values: (theta_h, theta_d, phi_d, channels).
        valid: bool (theta_h, theta_d, phi_d), at least one true.
    """
    for slice_values, slice_valid in zip(values, valid, strict=True):
        usable = slice_valid.copy()
        while usable.any() and not usable.all():
            _fill_once(slice_values, usable)
    empty = ~valid.any(axis=(1, 2))
    if empty.any():
        filled = np.flatnonzero(~empty)
        for i in np.flatnonzero(empty):
            values[i] = values[filled[np.argmin(np.abs(filled - i))]]


def _fill_once(values: np.ndarray, usable: np.ndarray) -> None:
    """Fill the bins of a slice (theta_d, phi_d) with a usable bin in their row or column.

    usable: bool (theta_d, phi_d); is updated in place.
    """
    count = usable.shape[1]
    in_column, column_distance = _nearest(usable)
    wrapped, row_distance = _nearest(np.tile(usable, (1, 3)).T)  # three periods
    in_row = wrapped.T[:, count : 2 * count] % count
    row_distance = row_distance.T[:, count : 2 * count]
    by_row = row_distance <= column_distance
    found = ~usable & np.isfinite(np.minimum(row_distance, column_distance))
    j, k = np.nonzero(found)
    source_j = np.where(by_row[j, k], j, in_column[j, k])
    source_k = np.where(by_row[j, k], in_row[j, k], k)
    values[j, k] = values[source_j, source_k]
    usable[j, k] = True


def _nearest(usable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the nearest usable entry along axis 0, and its distance (infinite if none is)."""
    count = len(usable)
    index = np.broadcast_to(np.arange(count)[:, None], usable.shape)
    before = np.maximum.accumulate(np.where(usable, index, -3 * count), axis=0)
    after = np.minimum.accumulate(np.where(usable, index, 3 * count)[::-1], axis=0)[::-1]
    nearest = np.where(index - before <= after - index, before, after)
    distance = np.abs(nearest - index).astype(np.float64)
    missing = distance > count
    return np.where(missing, 0, nearest), np.where(missing, np.inf, distance)
