"""The axes of the tables of `albedos`: index, root of the GGX width, and cosine.

Seen from the denser side, an interface reflects totally at grazing angles. The edge moves with the
index, and is sharp for smooth interfaces. The axis of the cosine follows it, so that tables that
are linear between their nodes have it in its place.
"""

import math
from typing import Any

import numpy as np

from urushi.checks import MIN_ALPHA

#: Nodes of the tables: of the index below one and from one, of the width, and of the cosine.
BELOW, ABOVE, ROUGHNESSES, COSINES = 21, 25, 16, 48

#: Nodes of the index.
INDICES = BELOW + ABOVE

#: Cells of the axis of the cosine below the edge of total reflection.
TOTAL_CELLS = 24

#: Largest magnitude of the amplitude (eta - 1) / (eta + 1): an index of 3, or of 1/3.
LARGEST_AMPLITUDE = 0.5

#: Root of the amplitude's share at the last node below one. From there to an index of one, where
#: nothing is reflected, tables are constant relative to the edge.
_LEAST_ROOT = 0.03

#: Coordinate of the edge of total reflection.
_EDGE = TOTAL_CELLS / (COSINES - 1)

#: Least cosine of a node.
_LEAST_COSINE = 1e-5


def indexnodes() -> np.ndarray:
    """The relative indices of the nodes (INDICES,), denser towards one."""
    below, above = np.linspace(-1, -_LEAST_ROOT, BELOW), np.linspace(0, 1, ABOVE)
    root = np.concatenate([below, above])
    amplitude = LARGEST_AMPLITUDE * np.abs(root) * root
    return (1 + amplitude) / (1 - amplitude)


def index_coordinate(eta: Any, xp: Any = np) -> Any:
    """Coordinate of an index in [0, 1]. None lies between the two nodes on either side of one."""
    amplitude = (eta - 1) / (eta + 1) / LARGEST_AMPLITUDE
    root = xp.sqrt(xp.abs(amplitude))
    below = (BELOW - 1) * xp.clip((1 - root) / (1 - _LEAST_ROOT), 0, 1)
    above = BELOW + (ABOVE - 1) * root
    return _select(eta < 1, below, above, xp) / (INDICES - 1)


def roughness_coordinate(alpha: Any, xp: Any = np) -> Any:
    """Where a GGX width lies among the nodes, in [0, 1]."""
    least = MIN_ALPHA**0.5
    return (xp.sqrt(alpha) - least) / (1 - least)


def cosine_coordinate(cosine: Any, eta: Any = None, xp: Any = np) -> Any:
    """Where a cosine lies among the nodes of an index, in [0, 1].

    It is the root of the cosine. For indices below one it is `_EDGE` at the cosine of total
    reflection, and above that linear in the root of the distance.

    eta: None in tables without index. A float is a constant.
    """
    root = xp.sqrt(xp.maximum(cosine, 0))
    constant = isinstance(eta, float)
    if eta is None or (constant and eta >= 1):
        return root
    edge = _edge(eta, xp)
    # Clipped where the derivatives have no bound.
    turn = xp.clip(1 - 2 * cosine / edge, -1 + 1e-6, 1 - 1e-6)
    total = (_EDGE / math.pi) * (xp.arccos if xp is np else xp.acos)(turn)
    beyond = xp.maximum((cosine - edge) / (1 - edge), 1e-8)
    split = _select(cosine < edge, total, _EDGE + (1 - _EDGE) * xp.sqrt(beyond), xp)
    return split if constant else _select(eta < 1, split, root, xp)


def nodes(eta: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The GGX widths and, of an index, the cosines of the nodes."""
    roughness = np.linspace(MIN_ALPHA**0.5, 1, ROUGHNESSES)
    cosine, _ = _cosine_at(np.linspace(0, 1, COSINES), eta)
    return roughness**2, np.maximum(cosine, _LEAST_COSINE)


def hemisphere_mean(table: np.ndarray, etas: np.ndarray | None = None) -> np.ndarray:
    """2 times the integral of a table (..., COSINES) times the cosine over [0, 1].

    The tables are interpolated linearly between their nodes. The integral of this interpolation is
    exact, up to rounding, where the cosine is a polynomial of the coordinate.

    etas: None, or the indices (I,) of a table (I, ROUGHNESSES, COSINES).
    """
    values, weight = between_nodes(table, etas)
    return (values * weight).sum(-1)


def between_nodes(
    table: np.ndarray, etas: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """A table (..., COSINES) at the points of a quadrature, (..., K), and their weights.

    The weights, (K,) or (I, 1, K), have a sum of one, as in `hemisphere_mean`. Multiply values of
    several tables before summing to get the mean of their product.
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    t, step = 0.5 * (points + 1), 1 / (COSINES - 1)
    x = ((np.arange(COSINES - 1)[:, None] + t) * step).ravel()
    values = table[..., :-1, None] * (1 - t) + table[..., 1:, None] * t
    given = [None] if etas is None else etas
    density = np.stack([np.prod(_cosine_at(x, eta), axis=0) for eta in given])
    weight = density * np.tile(weights, COSINES - 1)
    weight /= weight.sum(-1, keepdims=True)
    weight = weight[0] if etas is None else weight[:, None]
    return values.reshape(*table.shape[:-1], -1), weight


def _cosine_at(x: np.ndarray, eta: float | None) -> tuple[np.ndarray, np.ndarray]:
    """The inverse of `cosine_coordinate`, and its derivative."""
    if eta is None or eta >= 1:
        return x * x, 2 * x
    edge, total = float(_edge(eta, np)), x < _EDGE
    u, v = np.pi * np.minimum(x / _EDGE, 1), np.maximum(x - _EDGE, 0) / (1 - _EDGE)
    cosine = np.where(total, 0.5 * edge * (1 - np.cos(u)), edge + (1 - edge) * v * v)
    slope = np.where(
        total, 0.5 * np.pi * edge / _EDGE * np.sin(u), 2 * (1 - edge) / (1 - _EDGE) * v
    )
    return cosine, slope


def _edge(eta: Any, xp: Any) -> Any:
    """The cosine below which light meets total reflection, for an index from 1/3 to one."""
    eta = xp.maximum(eta, 1 / 3)
    return xp.sqrt(xp.maximum(1 - eta * eta, 1e-8))


def _select(condition: Any, first: Any, second: Any, xp: Any) -> Any:
    return (xp.where if xp is np else xp.select)(condition, first, second)
