"""Averages over random walks that start at given directions, in launches of bounded size."""

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np

from urushi.errors import ParameterError
from urushi.reference.bottoms import Bottom
from urushi.reference.device import types
from urushi.reference.lanes import TableLayers, table_bottom
from urushi.reference.rng import stream
from urushi.reference.stack import Stack
from urushi.reference.table import from_stack

#: Walks per kernel launch.
LANES = 1 << 20

#: One walk from `wi` through layers and bottom, with its random stream: a Dr.Jit float per lane.
Walk = Callable[[TableLayers, Bottom, Any, Any], Any]


def average(
    stack: Stack, wi: np.ndarray, walks: int, seed: int, walk: Walk
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error of `walk` for every direction and channel of a stack.

    Args:
        stack: the stack.
        wi: float32 (N, 3) unit vectors.
        walks: random walks per direction and channel, at least 2.
        seed: any integer.
        walk: what to average.

    Returns:
        (mean, se): float64 (N, 3).
    """
    if walks < 2:
        raise ParameterError(f"walks is {walks}; a standard error needs at least 2")
    if not len(wi):
        return np.zeros((0, 3)), np.zeros((0, 3))
    table, device = from_stack(stack), types()
    channels = len(table)
    lanes = len(wi) * channels
    directions = device.Array3f(np.ascontiguousarray(np.repeat(wi, channels, axis=0).T))
    total = np.zeros((2, lanes))
    block = max(min(walks, LANES // lanes), 1)
    for first in range(0, walks, block):
        count = min(block, walks - first)
        lane = dr.arange(device.UInt32, lanes * count)
        start = lane // count
        place = device.UInt64(start) * walks + device.UInt64(lane - start * count) + first
        row = start % channels
        value = walk(
            TableLayers(device, table, row),
            table_bottom(device, table, row),
            dr.gather(device.Array3f, directions, start),
            stream(device.PCG32, place, seed),
        )
        sums = dr.block_sum(value, count), dr.block_sum(value * value, count)
        dr.eval(*sums)
        total += np.stack([x.numpy().astype(np.float64) for x in sums])
    mean = total[0] / walks
    se = np.sqrt(np.maximum(total[1] / walks - mean * mean, 0) / (walks - 1))
    shape = len(wi), channels
    return tuple(np.broadcast_to(x.reshape(shape), (len(wi), 3)).copy() for x in (mean, se))  # type: ignore[return-value]
