"""Tables of ln f over directions, for the rest of constant materials and for measured BRDFs.

A renderer looks up the rest of a constant material. The numbers of a code are too few for a
measured BRDF, so its material has a table of f itself. f is interpolated linearly in three
coordinates in [0, 1]:

    u = (ln(tan^2 theta_h + `TAN2_OFFSET`) - `LOWEST`) / (`HIGHEST` - `LOWEST`)
    v = sqrt(1 - cos theta_d)
    w = 1 - sqrt(1 - |d| / min(c, s))

with the half and the difference angle of Rusinkiewicz (1998), c = (cos_i + cos_o) / 2,
d = (cos_i - cos_o) / 2 and s = sin theta_h sin theta_d; neither c nor s is below |d|. The nodes are
densest for small half angles, where lobes are narrow, and where a direction grazes the surface.
Tables of slabs have nodes at the angles of total reflection (`Knots`), and v is linear in between.

Exchanging wi and wo leaves the coordinates the same to the bit.
"""

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.core.namespace import NUMPY, Components, Namespace, stacked

#: Nodes in the coordinates.
SHAPE = 96, 32, 8

#: Of the coordinate u.
TAN2_OFFSET = 1e-5
LOWEST, HIGHEST = math.log(TAN2_OFFSET), math.log(1e3)

#: Of u and v: strides of the nodes at which coats and slabs are computed by light transport.
STRIDES = 3, 2

#: Coordinates v of angles of total reflection, ascending, and the nodes there.
Knots = tuple[tuple[float, int], ...]

#: Range to which ln f is clamped, so that f is positive and finite for any numbers.
MIN_LOG, MAX_LOG = -25.0, 16.0

#: Smallest cosine to the normal. Smaller ones are clamped to it, so f is constant near the horizon.
MIN_COSINE = 5e-3


def table_of_values(f: np.ndarray) -> np.ndarray:
    """The table float16 (U, V, W, C) of a BRDF with values f (N, C) [1/sr] at `node_pairs`."""
    logs = np.log(np.maximum(f, math.exp(MIN_LOG)))
    return logs.clip(MIN_LOG, MAX_LOG).reshape(*SHAPE, -1).astype(np.float16)


def interpolated(
    table: np.ndarray, wi: np.ndarray, wo: np.ndarray, knots: Knots = ()
) -> np.ndarray:
    """f float32 (N, C) [1/sr] of a table (U, V, W, C) for pairs (N, 3) above the horizon."""
    return interpolated_at(table, *pair_coordinates(wi, wo, knots))


def interpolated_at(table: np.ndarray, *places: np.ndarray) -> np.ndarray:
    """f float32 (N, C) [1/sr] of a table (..., C) at its coordinates, arrays (N,)."""
    return np.exp(linear_at(table, *places))


def linear_at(table: np.ndarray, *places: np.ndarray) -> np.ndarray:
    """Values float32 (N, C) of a table (..., C) at places (N,) in [0, 1] of its axes."""
    *shape, channels = table.shape
    rows, (first, shares) = table.reshape(-1, channels), _cells(shape, places)
    values = [  # `take` is several times as fast as an index
        rows.take(first + step, axis=0).astype(np.float32, copy=False)
        for step in corner_steps(shape)
    ]
    for share in reversed(shares):
        # Arrays of equal shapes: NumPy broadcasts along a short last axis slowly.
        repeated = np.repeat(share, channels).reshape(-1, channels)
        for low, high in zip(values[::2], values[1::2], strict=True):
            high -= low
            high *= repeated
            low += high
        values = values[::2]
    return values[0]


def corners(shape: Sequence[int], *places: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The nodes (N,) around places (N,) in a table, each with its share (N,)."""
    first, shares = _cells(shape, places)
    ends = itertools.product(*((1 - share, share) for share in shares))
    steps = zip(corner_steps(shape), ends, strict=True)
    return [(first + step, math.prod(sides)) for step, sides in steps]


def _cells(shape: Sequence[int], places: Sequence[np.ndarray]) -> tuple[Any, list[Any]]:
    """The first corners (N,) of the cells of places (N,), and the shares float32 of the places
    between both ends of a cell along each axis."""
    first, shares = 0, list[Any]()
    for place, count in zip(places, shape, strict=True):
        scaled = np.clip(place, 0, 1) * (count - 1)
        index = np.minimum(scaled.astype(np.intp), count - 2)
        first = first * count + index
        shares.append((scaled - index.astype(scaled.dtype)).astype(np.float32))
    return first, shares


def corner_steps(shape: Sequence[int]) -> list[int]:
    """Steps from the first corner of a cell of a table to all corners, the last axis fastest."""
    return [int(np.ravel_multi_index(corner, shape)) for corner in np.ndindex(*[2] * len(shape))]


def pair_coordinates(wi: np.ndarray, wo: np.ndarray, knots: Knots = ()) -> tuple[np.ndarray, ...]:
    """The coordinates (N,) of pairs (N, 3), see `coordinates`."""
    both, apart = (Components(*w.T.astype(np.float64)) for w in (wi + wo, wi - wo))
    return coordinates(both, apart, NUMPY, knots)


def coordinates(both: Any, apart: Any, xp: Namespace, knots: Knots = ()) -> tuple[Any, ...]:
    """The coordinates of pairs in [0, 1] up to rounding, from wi + wo and the z of wi - wo."""
    x2, y2 = both.x * both.x, both.y * both.y
    z2 = xp.named("z2", xp.maximum(both.z * both.z, 1e-18))
    squared = xp.named("squared", x2 + y2 + z2)
    cos_d = xp.named("cos_d", xp.minimum(0.5 * xp.sqrt(squared), 1))
    v = xp.safe_sqrt(1 - cos_d)  # roots that reach zero have finite derivatives if they are safe
    across = xp.named("across", x2 + y2)
    sin2 = (1 - cos_d) * (1 + cos_d)
    reach = xp.minimum(0.5 * both.z, xp.safe_sqrt(across / squared * sin2))
    size = xp.minimum(0.5 * xp.absolute(apart.z) / xp.maximum(reach, 1e-9), 1)
    v = knotted(v, knots, xp) if knots else v
    return log_tangent(across / z2, xp), v, 1 - xp.safe_sqrt(1 - size)


def log_tangent(tan2: Any, xp: Namespace) -> Any:
    """The coordinate u of a squared tangent."""
    return (xp.log(tan2 + TAN2_OFFSET) - LOWEST) * (1 / (HIGHEST - LOWEST))


def squared_tangent(u: Any, xp: Namespace = NUMPY) -> Any:
    """The squared tangent of a coordinate u, the inverse of `log_tangent` up to rounding."""
    return xp.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET


def interpolated_columns(x: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (M, C) at x (M,), linear between values (N, C) at ascending nodes (N,)."""
    return np.stack([np.interp(x, nodes, column) for column in values.T], axis=-1)


def v_of_sine(sine: float) -> float:
    """The coordinate v of a difference angle below 90 degrees, by its sine."""
    return (1 - (1 - sine * sine) ** 0.5) ** 0.5


def knots_of(sines: Sequence[float]) -> Knots:
    """The knots at angles of total reflection of sines below one, in any order.

    Nodes are about where they are without knots.
    """
    last, knots = SHAPE[1] - 1, list[tuple[float, int]]()
    for sine in sorted(sines):
        v = v_of_sine(sine)
        node = round(last * v)
        if node < last and (not knots or node > knots[-1][1] + 1):
            knots.append((v, node))
    return tuple(knots)


def knotted(v: Any, knots: Knots, xp: Namespace) -> Any:
    """The coordinate, with nodes at knots, of v: linear between them."""
    last, result = SHAPE[1] - 1, 0.0
    for (a, start), (b, end) in itertools.pairwise([(0.0, 0), *knots, (1.0, last)]):
        result = result + xp.clip(v - a, 0, b - a) * ((end - start) / last / (b - a))
    return result


def known_nodes(knots: Knots) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (K,) in u and (L,) in v that light transport computes."""
    u, v = (np.append(np.arange(0, n - 1, k), n - 1) for n, k in zip(SHAPE, STRIDES, strict=False))
    about = [node + step for _, node in knots for step in (-1, 0, 1)]
    return u, np.unique([*v, *about])


def known_pairs(knots: Knots = ()) -> list[np.ndarray]:
    """Pairs wi, wo float32 (N, 3) of the `known_nodes` and all nodes in w, which is fastest."""
    rows = np.ix_(*known_nodes(knots))
    return [w.reshape(*SHAPE, 3)[rows].reshape(-1, 3) for w in node_pairs(knots)]


def interpolated_nodes(f: np.ndarray, knots: Knots) -> np.ndarray:
    """Values (U, V, ...) at all nodes of values f (K, L, ...) at `known_nodes`.

    Logarithms are cubic (Lagrange) between four of these nodes, on one side of knots.
    """
    logs = np.log(np.maximum(f, math.exp(MIN_LOG)))
    for axis, (known, ends) in enumerate(
        zip(known_nodes(knots), ([], [n for _, n in knots]), strict=True)
    ):
        logs = np.moveaxis(logs, axis, 0)
        shares = np.zeros((SHAPE[axis], len(known)), np.float32)
        above = np.searchsorted(known, np.arange(SHAPE[axis])).clip(1, len(known) - 1)
        for low, high in itertools.pairwise(np.searchsorted(known, [0, *ends, known[-1]])):
            count = min(4, high - low + 1)
            for i in np.flatnonzero((above > low) & (above <= high)):
                first = np.clip(above[i] - 2, low, high + 1 - count)
                nodes, same = known[first : first + count], np.eye(count, dtype=bool)
                factors = (i - nodes) / np.where(same, 1, nodes[:, None] - nodes)
                shares[i, first : first + count] = np.where(same, 1, factors).prod(axis=1)
        between = logs[above - 1], logs[above]
        cubic = np.tensordot(shares, logs, 1)
        logs = np.moveaxis(cubic.clip(np.minimum(*between), np.maximum(*between)), 0, axis)
    return np.exp(logs)


@functools.lru_cache(maxsize=16)
def node_pairs(knots: Knots = ()) -> tuple[np.ndarray, np.ndarray]:
    """Pairs wi, wo float32 (N, 3) of the nodes, the last axis fastest.

    Cosines are at least `MIN_COSINE`.
    """
    axes = [np.linspace(0, 1, count) for count in SHAPE]
    if knots:  # the inverse of `knotted`
        edges, nodes = zip((0.0, 0), *knots, (1.0, SHAPE[1] - 1), strict=True)
        axes[1] = np.interp(axes[1] * nodes[-1], nodes, edges)
    places = (x.ravel() for x in np.meshgrid(*axes, indexing="ij"))
    pairs = node_directions(*places)
    for w in pairs:
        w[:, 2] = np.maximum(w[:, 2], MIN_COSINE)
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        w.flags.writeable = False
    return pairs


def node_directions(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A pair wi, wo float32 (N, 3) with the coordinates (N,), see `node_components`."""
    wi, wo = node_components(u, v, w, NUMPY)
    return stacked(wi).astype(np.float32), stacked(wo).astype(np.float32)


def node_components(u: Any, v: Any, w: Any, xp: Namespace) -> tuple[Components, Components]:
    """A pair wi, wo with three coordinates.

    Where a coordinate means nothing, as w for equal directions, any pair of the same f is one.
    """
    tan2 = xp.maximum(squared_tangent(u, xp), 1e-9)
    cos_h = xp.named("cos_h", 1 / xp.sqrt(1 + tan2))
    sin_h = xp.named("sin_h", xp.sqrt(tan2) * cos_h)
    cos_d = xp.named("cos_d", 1 - v * v)
    sin_d = xp.named("sin_d", xp.sqrt(xp.maximum(1 - cos_d * cos_d, 0)))
    both = xp.named("both", sin_h * sin_d)
    difference = (1 - (1 - w) * (1 - w)) * xp.minimum(cos_h * cos_d, both)
    cos_phi = xp.named("cos_phi", xp.where(both > 1e-12, difference / xp.maximum(both, 1e-12), w))
    sin_phi = xp.sqrt(xp.maximum(1 - cos_phi * cos_phi, 0))
    across = (cos_phi * cos_h * sin_d, sin_phi * sin_d, -1 * cos_phi * sin_h * sin_d)
    x, y, z = (xp.named(f"across_{k}", c) for k, c in zip("xyz", across, strict=True))
    along_x, along_z = sin_h * cos_d, cos_h * cos_d
    return Components(along_x + x, y, along_z + z), Components(along_x - x, -1 * y, along_z - z)
