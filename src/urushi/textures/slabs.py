"""Slabs whose parameters vary along axes: functions of directions, and their numbers at nodes.

The tables of a slab (`material.slab_table`) are computed at points of the axes. The logarithms of
all these tables are sums of their mean and of a few principal functions. The numbers of these
functions are smooth along the axes, and are interpolated to nodes (`interpolation.interpolant`). A
constant slab is a single node, and its channels have functions of their own.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from urushi.core import table
from urushi.material.slab_table import SlabTables, slab_tables
from urushi.textures.axes import Axis, Changes
from urushi.textures.baking import node_counts
from urushi.textures.interpolation import interpolant, points
from urushi.textures.point_codes import FAINT, slope_weights

#: Points at which tables are computed, by the number of axes.
POINTS = 1, 16, 40, 72, 104, 136, 168

#: Most axes.
AXES = len(POINTS) - 1

#: Numbers of functions that are tried; with the mean they fill packets. Largest root mean square
#: error of ln f over the light of a slab.
COUNTS, ERROR = (0, 1, 3, 7, 11, 15, 23, 31), 3e-3

#: Share of all nodes alike in the measure of this error.
FLOOR = 0.02

#: Most nodes along an axis of the lobes of samples, by the number of axes.
LOBES = 1, 9, 9, 5, 5, 3, 3


class Functions(NamedTuple):
    """ln (f + faint) of a table, a sum of functions of both directions."""

    table: np.ndarray  # float32 (..., 1 + K): the mean, and functions times a number each
    terms: int  # K


class Slabs(NamedTuple):
    """Slabs of C channels at N nodes of axes; C is one if channels are alike at the same values.

    A number is an optical depth on each side, the widths of the interfaces that each side mirrors
    light at (of `SlabTables.faces` and then `SlabTables.inner`), all of them as roots, which are
    nearly linear along axes; and the numbers of all functions.
    """

    axes: tuple[Axis, ...]
    shape: tuple[int, ...]  # number of nodes along each axis
    first: SlabTables  # at a point: what it says of indices holds at all of them
    reflected: tuple[Functions, ...]  # of a side or of both, divided by `mirrored_inside`
    passed: Functions  # divided by `grazing_factor`
    numbers: np.ndarray  # float32 (C, N, T), the last axis the fastest
    slopes: np.ndarray  # float32 (C, N, S, T) by the axes' values, and then by constants
    lobes: np.ndarray  # (..., L) of samples, at nodes of their own
    faint: float  # [1/sr]

    @property
    def roots(self) -> int:
        """How many numbers come before those of functions."""
        return self.numbers.shape[-1] - sum(x.terms for x in (*self.reflected, self.passed))


def bake(
    axes: Sequence[Axis],
    changes: Sequence[Changes],
    layers: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    lobes: Callable[[SlabTables], np.ndarray],
) -> Slabs:
    """Slabs at nodes of axes.

    Args:
        axes: along which slabs vary.
        changes: of the constants by which slopes are wanted, too.
        layers: the arguments of `slab_tables` at numbers (d + m,): values along the axes, and
            changes of the constants.
        lobes: numbers (L) of samples of a slab.
    """
    own, count, m = tuple(axes), len(axes), len(changes)
    x = points(count, POINTS[count]) if own else np.zeros((1, 0))
    values = np.stack([a.values(at) for a, at in zip(own, x.T, strict=True)], axis=-1) if own else x
    moved = np.zeros((1 + 3 * m, m))
    for k, change in enumerate(changes):
        moved[1 + 3 * k : 4 + 3 * k, k] = change
    every = [np.concatenate([value, change]) for value in values for change in moved]
    different, index = np.unique(every, axis=0, return_inverse=True)
    tables = [slab_tables(*layers(row)) for row in different]
    found = [tables[i] for i in np.ravel(index)]
    sides = 1 if all(t.reflected[0] is t.reflected[1] for t in tables) else 2
    faint = FAINT if len(tables) > 1 else 0.0
    parts = [np.stack([t.reflected[s].table for t in found]) for s in range(sides)]
    parts.append(np.stack([t.passed for t in found]))
    functions, numbers, sizes = zip(*(_principal(part, faint) for part in parts), strict=True)
    roots = np.stack([_roots(t) for t in found])  # (R, C, ...)
    every_number = np.concatenate([roots, *numbers], axis=-1)  # (R, C, T)
    size = every_number.shape[-1]
    at_points = every_number.reshape(len(x), len(moved), -1, size)
    norm = np.diag(np.concatenate([np.ones(roots.shape[-1]), *sizes]))
    smooth = interpolant(x, at_points[:, 0], norm)
    shape = node_counts(norm, lambda y: np.moveaxis(smooth(y), 1, 0), count)
    nodes = np.array([*np.ndindex(*shape)], float) / np.maximum(np.array(shape) - 1.0, 1)
    at_nodes = np.moveaxis(smooth(nodes), 1, 0)  # (C, N, T)
    slopes = np.empty((*at_nodes.shape[:2], count + m, size), np.float32)
    grid = at_nodes.reshape(-1, *shape, size)
    for k, axis in enumerate(own):
        along = axis.values(np.linspace(0, 1, shape[k]))
        slopes[:, :, k] = np.gradient(grid, along, axis=1 + k).reshape(at_nodes.shape)
    for k, change in enumerate(changes):
        weights = slope_weights(np.array([change]), np.zeros(1))[0]
        given = np.tensordot(weights, at_points[:, 1 + 3 * k : 4 + 3 * k], (0, 1))
        slopes[:, :, count + k] = np.moveaxis(interpolant(x, given, norm)(nodes), 1, 0)
    coarse = tuple(min(n, LOBES[count]) for n in shape)
    places = np.array([*np.ndindex(*coarse)], float) / np.maximum(np.array(coarse) - 1.0, 1)
    drawn = np.stack([lobes(t) for t in found[:: len(moved)]])
    flat = drawn.reshape(len(drawn), 1, -1)
    lobe_numbers = interpolant(x, flat, np.eye(flat.shape[-1]))(places)
    return Slabs(
        axes=own,
        shape=shape,
        first=tables[0],
        reflected=functions[:-1],
        passed=functions[-1],
        numbers=at_nodes.astype(np.float32),
        slopes=slopes,
        lobes=lobe_numbers.reshape(*coarse, *drawn.shape[1:]).clip(drawn.min(0), drawn.max(0)),
        faint=faint,
    )


def _roots(tables: SlabTables) -> np.ndarray:
    """The first numbers (C, ...) of a slab, see `Slabs`."""
    widths = [alpha for alpha, _ in tables.faces]
    widths += [alpha for side in tables.inner for _, alpha, _ in side]
    channels = tables.passed.shape[-1]
    shared = np.broadcast_to(widths, (channels, len(widths)))
    return np.sqrt(np.concatenate([tables.depths.T, shared], axis=1))


def _principal(logs: np.ndarray, faint: float) -> tuple[Functions, np.ndarray, np.ndarray]:
    """Functions of tables of logarithms (R, U, V, W, C), their numbers (R, C, K) and sizes (K,)."""
    count, *shape, channels = logs.shape
    rows = np.moveaxis(logs, -1, 1).astype(np.float32).reshape(count * channels, -1)
    if faint:
        rows = np.log(np.exp(rows) + faint)
    mean = rows.mean(axis=0)
    rows = rows - mean
    tan2 = table.squared_tangent(np.linspace(0, 1, shape[0]))
    solid = (tan2 / (1 + tan2) ** 2)[:, None]  # of equal steps in u
    light = (np.exp(mean).reshape(shape[0], -1) * solid).ravel()
    measure = light / light.sum() * (1 - FLOOR) + FLOOR / light.size
    spread = (rows * measure) @ rows.T
    sizes, axes = np.linalg.eigh(spread)
    order = np.argsort(-sizes)[: min(COUNTS[-1], len(rows))]
    for size in COUNTS:
        chosen = axes[:, order[:size]]
        left = np.diag(spread) - np.square(chosen) @ np.maximum(sizes[order[:size]], 0)
        if left.max() < ERROR**2:
            break
    found = chosen.T @ rows  # orthogonal in the measure, of the squared sizes `sizes`
    largest = np.maximum(np.abs(found).max(axis=1), 1e-9)
    functions = np.concatenate([mean[None], found / largest[:, None]]).T
    numbers = (chosen * largest).reshape(count, channels, -1)
    means = np.sqrt(np.maximum(sizes[order[: len(found)]], 0)) / largest
    return Functions(functions.reshape(*shape, -1).astype(np.float32), len(found)), numbers, means
