"""Averages of random walks over pairs of directions: for one Stack, or for a table of many."""

from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from urushi import checks
from urushi.errors import ParameterError
from urushi.reference import walk
from urushi.reference.device import types
from urushi.reference.lanes import TableLayers, table_bottom
from urushi.reference.rng import stream
from urushi.reference.stack import Stack
from urushi.reference.table import StackTable, from_stack

#: Walks per kernel launch; bounds device memory to a few hundred MB.
LANES = 1 << 22


def simulate(
    stack: Stack,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike,
    *,
    walks: int = 4096,
    seed: int = 0,
    progress: bool = True,
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the BRDF of a layered stack without bias, by position-free Monte Carlo.

    Args:
        stack: what to simulate (`urushi.coat`).
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal.
        walks: random walks per pair and channel, at least 2.
        seed: any integer; the same seed gives the same numbers on the same backend.
        progress: show a progress bar (on a terminal only).

    Returns:
        (f, se): float32 (N, 3) each, the BRDF [1/sr] without cosine and its standard error; both
        are zero where a direction is at or below the horizon.

    Raises:
        ParameterError: wrong shapes, directions that are not unit vectors, too few walks.
        PlatformError: no libLLVM that Dr.Jit can use.

    Source: Guo, Hasan & Zhao 2018 (unidirectional with next-event estimation and MIS).
    """
    if not isinstance(stack, Stack):
        raise ParameterError(
            f"simulate needs a Stack from urushi.coat(...), not {type(stack).__name__}"
        )
    wi, wo = checks.directions(wi, wo)
    table = from_stack(stack)
    channels, pairs = len(table), len(wi)
    row = np.tile(np.arange(channels, dtype=np.uint32), pairs)
    f, se = walk_pairs(
        table,
        row,
        np.repeat(wi, channels, axis=0),
        np.repeat(wo, channels, axis=0),
        walks=walks,
        seed=seed,
        progress=progress,
    )
    shape = (pairs, channels)
    return tuple(np.broadcast_to(x.reshape(shape), (pairs, 3)).copy() for x in (f, se))  # type: ignore[return-value]


def walk_pairs(
    table: StackTable,
    row: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    *,
    walks: int,
    seed: int,
    progress: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate f of row[i] of `table` at (wi[i], wo[i]) for every i.

    Args:
        table: S monochrome stacks.
        row: (M,) unsigned integers below S.
        wi, wo: float32 (M, 3) unit vectors.
        walks: random walks per pair, at least 2.
        seed: any integer.
        progress: show a progress bar (on a terminal only).

    Returns:
        (f, se): float32 (M,), mean [1/sr] and standard error.
    """
    if walks < 2:
        raise ParameterError(f"walks is {walks}; a standard error needs at least 2")
    if not len(row):
        return np.zeros(0, np.float32), np.zeros(0, np.float32)
    total = np.zeros((2, len(row)))
    device = types()
    block = min(walks, LANES)
    pairs_per_launch = max(LANES // block, 1)
    launches = -(-len(row) // pairs_per_launch) * -(-walks // block)
    with tqdm(total=launches, disable=None if progress else True, unit="launch") as bar:
        for start in range(0, len(row), pairs_per_launch):
            part = slice(start, start + pairs_per_launch)
            for first in range(0, walks, block):
                count = min(block, walks - first)
                total[:, part] += _launch(
                    device, table, row[part], wi[part], wo[part], count, (start, first), seed, walks
                )
                bar.update()
    mean = total[0] / walks
    variance = np.maximum(total[1] / walks - mean * mean, 0) / (walks - 1)
    top = _top(device, table, row, wi, wo)
    return (mean + top).astype(np.float32), np.sqrt(variance).astype(np.float32)


def _launch(
    device: Any,
    table: StackTable,
    row: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    count: int,
    first: tuple[int, int],
    seed: int,
    walks: int,
) -> np.ndarray:
    """Sum and sum of squares of `count` walks for each pair, (2, pairs).

    Each walk's random stream depends on its place in the whole request alone, so that the result
    is the same however the request is cut into launches.
    """
    lanes = len(row) * count
    lane = dr.arange(device.UInt32, lanes)
    pair = lane // count if count > 1 else lane
    place = (device.UInt64(pair) + first[0]) * walks + device.UInt64(lane - pair * count) + first[1]
    rng = stream(device.PCG32, place, seed)
    lane_row = dr.gather(device.UInt32, device.UInt32(np.ascontiguousarray(row, np.uint32)), pair)
    lane_wi, lane_wo = (
        dr.gather(device.Array3f, device.Array3f(np.ascontiguousarray(w.T)), pair) for w in (wi, wo)
    )
    f = walk.estimate(
        TableLayers(device, table, lane_row),
        table_bottom(device, table, lane_row),
        lane_wi,
        lane_wo,
        rng,
        device.Float,
    )
    sums = dr.block_sum(f, count), dr.block_sum(f * f, count)
    dr.eval(*sums)
    return np.stack([x.numpy().astype(np.float64) for x in sums])


def _top(
    device: Any, table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """The topmost interface's own reflection, (M,)."""
    rows = device.UInt32(np.ascontiguousarray(row, np.uint32))
    wi, wo = (device.Array3f(np.ascontiguousarray(w.T)) for w in (wi, wo))
    return walk.top_reflection(TableLayers(device, table, rows), wi, wo).numpy()
