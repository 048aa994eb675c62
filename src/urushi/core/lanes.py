"""Sums over many points, as Dr.Jit kernels with a lane for each point of each pair of each job.

A job has numbers and tables of its own; all jobs have the same pairs, and all pairs the same number
of points. What a lane computes is written in the formulas of `core.namespace`, so that its authors
need no Dr.Jit.
"""

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr
import numpy as np

from urushi.core.backend import backend, shared
from urushi.core.table import corner_steps

#: Lanes of a kernel launch; bounds the memory to some hundred MB.
LANES = 1 << 22


class Lane:
    """The point, the pair and the job of a lane, for all lanes at once."""

    def __init__(self, jobs: int, pairs: Sequence[np.ndarray], points: int) -> None:
        """pairs: arrays (N, 3). points: of each pair, at most 2^12."""
        self._device, count = backend(), len(pairs[0])
        lane = dr.arange(self._device.UInt32, jobs * count * points)
        row = lane // points
        self._point, self._pairs = lane - row * points, pairs
        # From arrays, so that one kernel serves any number of pairs
        self._job, self._pair = (
            dr.gather(self._device.UInt32, shared(self._device.UInt32, places), row)
            for places in np.divmod(np.arange(jobs * count, dtype=np.uint32), np.uint32(count))
        )

    def directions(self) -> list[Any]:
        """Both directions of the pair, vectors of Dr.Jit."""
        return [
            self._device.Array3f(
                *(dr.gather(self._device.Float, self._floats(x), self._pair) for x in w.T)
            )
            for w in self._pairs
        ]

    def number(self, values: np.ndarray) -> Any:
        """The job's number of values (D,)."""
        return dr.gather(self._device.Float, self._floats(values), self._job)

    def lattice(self, count: int, generator: int, first: int = 0, numbers: int = 4) -> list[Any]:
        """Numbers of the point, from the point `first` on, of a lattice of Korobov (1959)."""
        index = self._point + first
        powers = (pow(generator, k, count) for k in range(numbers))
        return [(self._device.Float(index * p % count) + 0.5) / count for p in powers]

    def table(self, values: np.ndarray) -> Callable[[Sequence[Any]], Any]:
        """Look-up, at coordinates in [0, 1], of the job's table of values (D, ...)."""
        flat, shape = self._floats(values), values.shape[1:]

        return lambda places: interpolated(flat, shape, places, self._job)

    def nearest(self, values: np.ndarray) -> Callable[[Any], Any]:
        """Look-up, at places in [0, 1], of the job's values (D, M) at even distances."""
        flat, last = self._floats(values), values.shape[1] - 1
        index_kind = self._device.UInt32
        first = self._job * values.shape[1]
        return lambda x: dr.gather(self._device.Float, flat, first + index_kind(x * last))

    def _floats(self, values: np.ndarray) -> Any:
        return shared(self._device.Float, values.astype(np.float32, copy=False))


def cell(shape: Sequence[int], places: Sequence[Any], table: Any) -> tuple[Any, list[Any]]:
    """The cells of a table in which places are, each a number in [0, 1] along every axis.

    table: index (UInt32) of the table in a sequence of tables of this shape.

    Returns:
        The index of the cell's lowest corner (`core.table.corner_steps` lead to the others), and
        the share of the place between both ends of the cell along each axis.
    """
    first, shares = table, []
    for place, count in zip(places, shape, strict=True):
        along = place * (count - 1)
        index = dr.minimum(type(table)(along), count - 2)
        first = first * count + index
        shares.append(along - type(along)(index))
    return first, shares


def interpolated(flat: Any, shape: Sequence[int], places: Sequence[Any], table: Any) -> Any:
    """Look-up at places, clipped to [0, 1], that is linear along each axis.

    flat: the numbers of a sequence of tables of a shape. table: as of `cell`.
    """
    first, shares = cell(shape, [dr.clip(place, 0, 1) for place in places], table)
    found = [dr.gather(type(flat), flat, first + step) for step in corner_steps(shape)]
    for share in reversed(shares):
        pairs = zip(found[::2], found[1::2], strict=True)
        found = [dr.fma(share, high - low, low) for low, high in pairs]
    return found[0]


def sums(
    value: Callable[[Lane], Any], jobs: int, pairs: Sequence[np.ndarray], points: int
) -> np.ndarray:
    """Sums float32 (N, D) over the points of each of the N pairs of each of the D jobs.

    value: returns the summands of all lanes.
    """
    count = len(pairs[0])
    result, size = np.empty((jobs, count), np.float32), max(LANES // (jobs * points), 1)
    for start in range(0, count, size):
        part = [w[start : start + size] for w in pairs]
        total = dr.block_sum(value(Lane(jobs, part, points)), points)
        result[:, start : start + size] = total.numpy().reshape(jobs, -1)
    return result.T
