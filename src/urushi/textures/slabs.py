"""Slabs whose parameters vary along axes: functions of directions, and their numbers at nodes.

The tables of a slab (`material.slab_table`) are computed at points of the axes. The logarithms of
all these tables are sums of their mean and of a few principal functions. The numbers of these
functions are smooth along the axes, and are interpolated to nodes (`interpolation.interpolant`). A
constant slab is a single node, and its channels have functions of their own.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from urushi.core import table
from urushi.material.slab_table import SlabTables, slab_tables
from urushi.textures.axes import DARK, LEVELS, Axis, Changes
from urushi.textures.baking import node_counts
from urushi.textures.interpolation import interpolant, left_out, points
from urushi.textures.point_codes import slope_weights

#: Points at which tables are computed at most, by the number of axes. A part of them is enough
#: where interpolation from all but one of them has a smaller error of ln f than `ENOUGH`.
POINTS = 1, 32, 64, 112, 144, 176, 208
PARTS, ENOUGH = (4, 2, 1), 0.02

#: Most nodes of all axes.
NODES = 1 << 14

#: Most axes.
AXES = len(POINTS) - 1

#: Numbers of functions that are tried; with the mean they fill packets. Largest root mean square
#: error of ln f over the light of a slab.
COUNTS, ERROR = (0, 1, 3, 7, 11, 15, 23, 31), 3e-3

#: Added to f over its mean in logarithms, and subtracted again from what they evaluate to: they are
#: smooth where f becomes black.
FAINT = 0.01

#: Share of all nodes alike in the measure of this error.
FLOOR = 0.02

#: Of the bar that is shown on a terminal where tables take longer than a moment.
PROGRESS: dict[str, Any] = {"desc": "tables of a slab", "unit": "", "delay": 3.0, "disable": None}

#: Most nodes along an axis of the lobes of samples, by the number of axes.
LOBES = 1, 9, 9, 5, 5, 3, 3


class Functions(NamedTuple):
    """f of a table by numbers: exp(gain) (exp(a sum of functions of both directions) - faint)."""

    table: np.ndarray  # float32 (..., 1 + K): the mean, and functions times a number each

    @property
    def numbers(self) -> int:
        """1 + K: the gain, and those of functions."""
        return self.table.shape[-1]


class Slabs(NamedTuple):
    """Slabs of C channels at N nodes of axes; C is one if channels are alike at the same values.

    The first numbers are an optical depth on each side, and the widths of `SlabTables.faces` and of
    `SlabTables.inner`: roots of depths and logarithms of widths plus `axes.DARK`, which are about
    linear along axes. The numbers of each of the `functions` follow.
    """

    shape: tuple[int, ...]  # number of nodes along each axis
    first: SlabTables  # at one point: its indices are those of all
    #: What a side or both reflect, divided by `mirrored_inside`; what passes, by `grazing_factor`.
    functions: tuple[Functions, ...]
    numbers: np.ndarray  # (C, N, T), the last axis the fastest
    slopes: np.ndarray  # float32 (C, N, S, T) by the values of axes, and then by constants
    lobes: np.ndarray  # (..., L) of samples, at nodes of their own
    faint: float  # of `Functions`


def bake(
    axes: Sequence[Axis],
    sloped: Sequence[int],
    changes: Sequence[Changes],
    layers: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    lobes: Callable[[SlabTables], np.ndarray],
    apart: Callable[[np.ndarray], np.ndarray],
) -> Slabs:
    """Slabs at nodes of axes.

    Args:
        axes: along which slabs vary.
        sloped: axes by which slopes are wanted.
        changes: of the constants by which slopes are wanted.
        layers: the arguments of `slab_tables` at numbers (d + m,): values along the axes, and
            changes of the constants.
        lobes: numbers (L) of samples of a slab.
        apart: from coordinates (n, d) along the axes to those (n, d') by whose distances slabs
            differ.
    """
    d, known = len(axes), dict[bytes, SlabTables]()
    for part in PARTS:
        # Colours tell slabs apart, also between the levels of the wavelength.
        x = points([LEVELS] * d, POINTS[d] // part) if axes else np.zeros((1, 0))
        at = _at_points(x, axes, changes, layers, known)
        if not axes or left_out(apart(x), at.numbers[:, 0], at.norm) < ENOUGH:
            break
    x = apart(x)
    smooth = interpolant(x, at.numbers[:, 0], at.norm)
    shape = node_counts(at.norm, lambda y: np.moveaxis(smooth(apart(y)), 1, 0), d, NODES)
    nodes = apart(_grid(shape))
    numbers = np.moveaxis(smooth(nodes), 1, 0)
    grid, slopes = numbers.reshape(-1, *shape, len(at.norm)), []
    for k in sloped:
        along = axes[k].values(np.linspace(0, 1, shape[k]))
        slopes.append(np.gradient(grid, along, axis=1 + k).reshape(numbers.shape))
    for k, change in enumerate(changes):
        (weights,) = slope_weights(np.array([change]), np.zeros(1))
        own = np.tensordot(weights, at.numbers[:, 1 + 3 * k : 4 + 3 * k], (0, 1))
        slopes.append(np.moveaxis(interpolant(x, own, at.norm)(nodes), 1, 0))
    drawn = np.stack([lobes(t) for t in at.tables])
    coarse = tuple(min(n, LOBES[d]) for n in shape)
    between = interpolant(x, drawn.reshape(len(drawn), 1, -1), np.eye(drawn[0].size))
    rest = between(apart(_grid(coarse)))
    return Slabs(
        shape=shape,
        first=at.tables[0],
        functions=at.functions,
        numbers=numbers,
        slopes=np.stack(slopes, axis=2) if slopes else numbers[:, :, None, :0],
        lobes=rest.reshape(*coarse, *drawn.shape[1:]).clip(drawn.min(axis=0), drawn.max(axis=0)),
        faint=at.faint,
    )


class AtPoints(NamedTuple):
    """Slabs at P points of the axes, and each after changes of constants."""

    tables: list[SlabTables]  # P, without changes
    functions: tuple[Functions, ...]
    numbers: np.ndarray  # (P, 1 + changes, C, T)
    norm: np.ndarray  # (T, T) by which an error e of numbers changes ln f by |e norm|
    faint: float


def _at_points(
    x: np.ndarray,
    axes: Sequence[Axis],
    changes: Sequence[Changes],
    layers: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    known: dict[bytes, SlabTables],
) -> AtPoints:
    """Slabs at points; known: tables by the numbers of `layers`, to which new ones are added."""
    rows = np.zeros((len(x), 1 + 3 * len(changes), len(axes) + len(changes)))
    for k, axis in enumerate(axes):
        rows[..., k] = axis.values(x[:, k])[:, None]
    for k, change in enumerate(changes):
        rows[:, 1 + 3 * k : 4 + 3 * k, len(axes) + k] = change
    each = [row for point in rows for row in point]
    new = {row.tobytes(): row for row in each if row.tobytes() not in known}
    for key, row in tqdm(new.items(), **PROGRESS):
        known[key] = slab_tables(*layers(row))
    found = [known[row.tobytes()] for row in each]
    faint = FAINT if len(known) > 1 else 0.0
    functions, numbers, sizes = zip(
        *(_principal(part, faint) for part in _logs(found)), strict=True
    )
    first = np.stack([_first(t) for t in found])
    every = np.concatenate([first, *numbers], axis=-1)
    every = every.reshape(*rows.shape[:2], *every.shape[1:])
    norm = np.diag(np.concatenate([np.ones(first.shape[-1]), *sizes]))
    return AtPoints(found[:: rows.shape[1]], functions, every, norm, faint)


def _grid(shape: tuple[int, ...]) -> np.ndarray:
    """Coordinates (N, d) of nodes, the last axis the fastest."""
    return np.array([*np.ndindex(*shape)], float) / np.maximum(np.array(shape) - 1.0, 1)


def _logs(found: Sequence[SlabTables]) -> list[np.ndarray]:
    """Tables (R, U, V, W, C) of light that a side or both reflect, and of light that passes."""
    sides = 1 if all(t.reflected[0] is t.reflected[1] for t in found) else 2
    reflected = [np.stack([t.reflected[k].table for t in found]) for k in range(sides)]
    return [*reflected, np.stack([t.passed for t in found])]


def _first(tables: SlabTables) -> np.ndarray:
    """The first numbers (C, ...) of a slab, see `Slabs`."""
    widths = [alpha for alpha, _ in tables.faces]
    widths += [alpha for side in tables.inner for _, alpha, _ in side]
    shared = np.tile(np.log(np.array(widths) + DARK), (tables.depths.shape[1], 1))
    return np.concatenate([np.sqrt(tables.depths.T), shared], axis=1)


def _principal(logs: np.ndarray, faint: float) -> tuple[Functions, np.ndarray, np.ndarray]:
    """Functions of tables of logarithms (R, U, V, W, C), their numbers (R, C, 1 + K), and the
    change of ln f by each.
    """
    count, *shape, channels = logs.shape
    rows = np.moveaxis(logs, -1, 1).astype(np.float32).reshape(count * channels, -1)
    tan2 = table.squared_tangent(np.linspace(0, 1, shape[0]))
    solid = np.repeat(tan2 / (1 + tan2) ** 2, rows.shape[1] // shape[0])  # of equal steps in u
    light = np.exp(rows) * (solid / solid.sum())
    gains = np.log(light.sum(axis=1, keepdims=True))
    light = light / np.exp(gains) * (1 - FLOOR) + FLOOR / solid.size  # a measure of each row
    rows = np.log(np.exp(rows - gains) + faint)
    mean, measure = rows.mean(axis=0), light.mean(axis=0)
    rows -= mean
    spread, axes = np.linalg.eigh((rows * measure) @ rows.T)
    order = np.argsort(-spread)[: COUNTS[-1]]
    for size in COUNTS:
        chosen = axes[:, order[:size]]
        found = chosen.T @ rows
        if (np.square(rows - chosen @ found) * light).sum(axis=1).max() < ERROR**2:
            break
    largest = np.maximum(np.abs(found).max(axis=1), 1e-9)
    functions = np.concatenate([mean[None], found / largest[:, None]]).T
    numbers = np.concatenate([gains, chosen * largest], axis=1).reshape(count, channels, -1)
    sizes = np.sqrt(np.maximum(spread[order[: len(found)]], 0)) / largest
    functions = functions.reshape(*shape, -1).astype(np.float32)
    return Functions(functions), numbers, np.append(1, sizes)
