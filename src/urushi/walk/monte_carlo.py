"""Monte Carlo means over random walks, with standard errors, in kernel launches of bounded size."""

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr
import numpy as np
from tqdm import tqdm

from urushi.core.backend import backend, shared
from urushi.core.random import stream
from urushi.errors import ParameterError
from urushi.walk.bottoms import Description
from urushi.walk.stack import Stack
from urushi.walk.table import StackTable, TableLayers, from_stack, table_bottom

#: Walks per kernel launch; bounds device memory to a few hundred MB.
LANES = 1 << 22

#: One walk per lane: walk(layers, bottom, *directions, rng) returns a Dr.Jit float.
Walk = Callable[..., Any]


def per_channel(
    described: Stack | Description,
    directions: Sequence[np.ndarray],
    function: Callable[..., tuple[np.ndarray, ...]],
) -> tuple[np.ndarray, ...]:
    """Evaluate a function for every channel of a description; returns its results, (N, 3) each.

    directions: arrays float32 (N, 3) of unit vectors.
    function: function(table, row, *directions) -> arrays (M,), see `average`.
    """
    table, count = from_stack(described), len(directions[0])
    channels = len(table)
    row = np.tile(np.arange(channels, dtype=np.uint32), count)
    found = function(table, row, *(np.repeat(w, channels, axis=0) for w in directions))
    return tuple(np.broadcast_to(x.reshape(count, channels), (count, 3)).copy() for x in found)


def average(
    table: StackTable,
    row: np.ndarray,
    directions: Sequence[np.ndarray],
    walk: Walk,
    *,
    walks: int,
    seed: int,
    progress: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error of `walk` through row[i] of `table` for directions[...][i].

    The random numbers of a walk depend on its number and the number of its row alone, so that the
    result does not depend on how the walks are divided into launches.

    Args:
        table: S monochrome stacks.
        row: (M,) unsigned integers below S.
        directions: arrays float32 (M, 3) of unit vectors, the arguments of the walk.
        walk: the function to average.
        walks: random walks per row, at least 2.
        seed: any integer.
        progress: show a progress bar (on a terminal only).

    Returns:
        (mean, se): float64 (M,).
    """
    for name, value in (("walks", walks), ("seed", seed)):
        if not isinstance(value, int | np.integer):
            raise ParameterError(f"{name} is {value!r}; give a whole number")
    walks, seed = int(walks), int(seed)  # sums of NumPy's are cut to their bits
    if walks < 2:
        raise ParameterError(f"walks is {walks}; a standard error needs at least 2")
    device = backend()

    def launch(part: slice, first: int, count: int) -> np.ndarray:
        """Sums and sums of squares, (2, rows), of the walks from `first` on for a part's rows."""
        rows = shared(device.UInt32, row[part].astype(np.uint32))
        lane = dr.arange(device.UInt32, len(rows) * count)
        start = lane // count if count > 1 else lane
        place = device.UInt64(start) + part.start
        place = place * walks + device.UInt64(lane - start * count) + first
        lane_row = dr.gather(device.UInt32, rows, start)
        vectors = (device.Array3f(np.ascontiguousarray(w[part].T)) for w in directions)
        value = walk(
            TableLayers(device, table, lane_row),
            table_bottom(device, table, lane_row),
            *(dr.gather(device.Array3f, w, start) for w in vectors),
            stream(device.PCG32, place, seed),
        )
        sums = dr.block_sum(value, count), dr.block_sum(value * value, count)
        dr.eval(*sums)
        return np.stack([x.numpy().astype(np.float64) for x in sums])

    total = np.zeros((2, len(row)))
    block = min(walks, LANES)
    together = max(LANES // block, 1)
    launches = -(-len(row) // together) * -(-walks // block)
    with tqdm(total=launches, disable=None if progress else True, unit="launch") as bar:
        for start in range(0, len(row), together):
            part = slice(start, start + together)
            for first in range(0, walks, block):
                total[:, part] += launch(part, first, min(block, walks - first))
                bar.update()
    mean = total[0] / walks
    variance = np.maximum(total[1] / walks - mean * mean, 0) / (walks - 1)
    return mean, np.sqrt(variance)
