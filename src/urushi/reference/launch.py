"""Averages over random walks that start at given directions, in launches of bounded size.

Which Dr.Jit backend the reference runs on: CUDA where there is one, else LLVM.
"""

import functools
import importlib
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import drjit as dr
import numpy as np
from tqdm import tqdm

from urushi import platform
from urushi.errors import ParameterError
from urushi.physics.random import stream
from urushi.reference.stack import Stack
from urushi.reference.table import StackTable, TableLayers, from_stack, table_bottom

#: Walks per kernel launch; bounds device memory to a few hundred MB.
LANES = 1 << 22

#: One walk through layers and bottom, for directions, with its random stream: walk(layers, bottom,
#: *directions, rng) is a Dr.Jit float per lane.
Walk = Callable[..., Any]


def per_channel(
    stack: Stack,
    directions: Sequence[np.ndarray],
    function: Callable[..., tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray]:
    """Call a function of rows for every channel of a stack.

    Args:
        stack: the stack.
        directions: float32 (N, 3) unit vectors each.
        function: function(table, row, *directions) -> two arrays (M,), see `average`.

    Returns:
        Its results (N, 3) each.
    """
    table, count = from_stack(stack), len(directions[0])
    channels = len(table)
    row = np.tile(np.arange(channels, dtype=np.uint32), count)
    mean, se = (
        np.broadcast_to(x.reshape(count, channels), (count, 3)).copy()
        for x in function(table, row, *(np.repeat(w, channels, axis=0) for w in directions))
    )
    return mean, se


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

    Args:
        table: S monochrome stacks.
        row: (M,) unsigned integers below S.
        directions: float32 (M, 3) unit vectors each, which the walk is given.
        walk: what to average.
        walks: random walks per row, at least 2.
        seed: any integer.
        progress: show a progress bar (on a terminal only).

    Returns:
        (mean, se): float64 (M,).
    """
    if walks < 2:
        raise ParameterError(f"walks is {walks}; a standard error needs at least 2")
    total = np.zeros((2, len(row)))
    block = min(walks, LANES)
    rows_per_launch = max(LANES // block, 1)
    launches = -(-len(row) // rows_per_launch) * -(-walks // block)
    with tqdm(total=launches, disable=None if progress else True, unit="launch") as bar:
        for start in range(0, len(row), rows_per_launch):
            part = slice(start, start + rows_per_launch)
            some = [w[part] for w in directions]
            for first in range(0, walks, block):
                count = min(block, walks - first)
                at = start, first
                total[:, part] += _launch(table, row[part], some, walk, count, at, seed, walks)
                bar.update()
    mean = total[0] / walks
    variance = np.maximum(total[1] / walks - mean * mean, 0) / (walks - 1)
    return mean, np.sqrt(variance)


def _launch(
    table: StackTable,
    row: np.ndarray,
    directions: Sequence[np.ndarray],
    walk: Walk,
    count: int,
    first: tuple[int, int],
    seed: int,
    walks: int,
) -> np.ndarray:
    """Sum and sum of squares of `count` walks for each row, (2, rows).

    Each walk's random stream depends on its place in the whole request alone, so that the result
    is the same however the request is cut into launches.
    """
    device = types()
    lane = dr.arange(device.UInt32, len(row) * count)
    start = lane // count if count > 1 else lane
    place = device.UInt64(start) + first[0]
    place = place * walks + device.UInt64(lane - start * count) + first[1]
    lane_row = dr.gather(device.UInt32, device.UInt32(np.ascontiguousarray(row, np.uint32)), start)
    value = walk(
        TableLayers(device, table, lane_row),
        table_bottom(device, table, lane_row),
        *(
            dr.gather(device.Array3f, device.Array3f(np.ascontiguousarray(w.T)), start)
            for w in directions
        ),
        stream(device.PCG32, place, seed),
    )
    sums = dr.block_sum(value, count), dr.block_sum(value * value, count)
    dr.eval(*sums)
    return np.stack([x.numpy().astype(np.float64) for x in sums])


@functools.cache
def types() -> ModuleType:
    """The module of Dr.Jit array types to use (`drjit.cuda` or `drjit.llvm`).

    Raises:
        PlatformError: there is no GPU, and no libLLVM that Dr.Jit can use.
    """
    if dr.has_backend(dr.JitBackend.CUDA):
        return importlib.import_module("drjit.cuda")
    platform.require_llvm()
    return importlib.import_module("drjit.llvm")
