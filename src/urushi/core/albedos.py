"""Directional albedos of rough interfaces, tabulated.

The interfaces scatter once: light that would hit a second facet is lost. These tables give the
loss, for which `energy_compensation` of coats and the plugin `openpbr` compensate.

The axes of the tables are the index, the root of the GGX width, and the cosine. Seen from the
denser side, an interface reflects totally at grazing angles. The edge moves with the index, and is
sharp for smooth interfaces. The axis of the cosine follows it, so that tables that are linear
between their nodes have it in its place.
"""

import functools
import math
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core import fresnel, microfacet
from urushi.core.backend import backend
from urushi.core.microfacet import pair
from urushi.core.namespace import DRJIT, NUMPY, Namespace

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

#: Nodes of the quadrature over visible facets: of their azimuth, and of their height. Where some of
#: them reflect totally, the share that does decides, and the nodes are `FINE`.
COARSE, FINE = (20, 40), (28, 57)

#: Directions at a time: bounds memory.
CHUNK = 1 << 16


def indexnodes() -> np.ndarray:
    """The relative indices of the nodes (INDICES,), denser towards one."""
    below, above = np.linspace(-1, -_LEAST_ROOT, BELOW), np.linspace(0, 1, ABOVE)
    root = np.concatenate([below, above])
    amplitude = LARGEST_AMPLITUDE * np.abs(root) * root
    return (1 + amplitude) / (1 - amplitude)


def index_coordinate(eta: Any, xp: Namespace = NUMPY) -> Any:
    """Coordinate of an index in [0, 1]. None lies between the two nodes on either side of one."""
    amplitude = (eta - 1) / (eta + 1) / LARGEST_AMPLITUDE
    root = xp.sqrt(xp.absolute(amplitude))
    below = (BELOW - 1) * xp.clip((1 - root) / (1 - _LEAST_ROOT), 0, 1)
    above = BELOW + (ABOVE - 1) * root
    return xp.where(eta < 1, below, above) / (INDICES - 1)


def roughness_coordinate(alpha: Any, xp: Namespace = NUMPY) -> Any:
    """Where a GGX width lies among the nodes, in [0, 1]."""
    least = MIN_ALPHA**0.5
    return (xp.sqrt(alpha) - least) / (1 - least)


def cosine_coordinate(cosine: Any, eta: Any = None, xp: Namespace = NUMPY) -> Any:
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
    total = (_EDGE / math.pi) * xp.arccos(turn)
    beyond = xp.maximum((cosine - edge) / (1 - edge), 1e-8)
    split = xp.where(cosine < edge, total, _EDGE + (1 - _EDGE) * xp.sqrt(beyond))
    return split if constant else xp.where(eta < 1, split, root)


def nodes(eta: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The GGX widths and, of an index, the cosines of the nodes."""
    roughness = np.linspace(MIN_ALPHA**0.5, 1, ROUGHNESSES)
    cosine, _ = _cosine_at(np.linspace(0, 1, COSINES), eta)
    return roughness**2, np.maximum(cosine, _LEAST_COSINE)


def hemisphere_mean(
    table: np.ndarray, etas: np.ndarray | None = None, *, entered: bool = False
) -> np.ndarray:
    """Mean of a table (..., COSINES) over diffuse light: 2 int_0^1 table(c) c dc.

    The tables are interpolated linearly between their nodes. The integral of this interpolation is
    exact, up to rounding, where the cosine is a polynomial of the coordinate.

    etas: None, or the indices (I,) of a table (I, ROUGHNESSES, COSINES).
    entered: only over directions that a smooth interface does not reflect totally.
    """
    values, weight = between_nodes(table, etas)
    if entered:
        assert etas is not None
        beyond = np.linspace(0, COSINES - 1, weight.shape[-1]) > TOTAL_CELLS
        weight = np.where((etas[:, None, None] < 1) & ~beyond, 0, weight)
        weight /= weight.sum(-1, keepdims=True)
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
    edge, total = float(_edge(eta, NUMPY)), x < _EDGE
    u, v = np.pi * np.minimum(x / _EDGE, 1), np.maximum(x - _EDGE, 0) / (1 - _EDGE)
    cosine = np.where(total, 0.5 * edge * (1 - np.cos(u)), edge + (1 - edge) * v * v)
    slope = np.where(
        total, 0.5 * np.pi * edge / _EDGE * np.sin(u), 2 * (1 - edge) / (1 - _EDGE) * v
    )
    return cosine, slope


def _edge(eta: Any, xp: Namespace) -> Any:
    """The cosine below which light meets total reflection, for an index from 1/3 to one."""
    eta = xp.maximum(eta, 1 / 3)
    return xp.sqrt(xp.maximum(1 - eta * eta, 1e-8))


class Tables(NamedTuple):
    """Albedos at the nodes, float32 (I, ROUGHNESSES, COSINES); their means have no cosine."""

    reflected: np.ndarray  # of the light from above, at the cosines of `nodes` of the index
    passed: np.ndarray
    reflected_mean: np.ndarray  # over diffuse light
    passed_mean: np.ndarray
    # Over diffuse light that has entered by a smooth interface of the same index, and that a mirror
    # returns.
    reflected_entered: np.ndarray
    passed_entered: np.ndarray
    inside: np.ndarray  # the mean cosine of the transmitted light; empty for two widths


@functools.cache
def tables(eta: float | None = None) -> Tables:
    """The tables of dielectric interfaces.

    eta: the only index, I is 1; None: all of `indexnodes`, which takes seconds the first time.
    """
    etas = indexnodes() if eta is None else np.array([eta])
    return tables_of(etas, nodes()[0])


def tables_of(etas: np.ndarray, widths: np.ndarray) -> Tables:
    """`tables` at indices and GGX widths."""
    found = []
    for index in map(float, etas):
        alphas, cosines = np.meshgrid(widths, nodes(index)[1], indexing="ij")
        w = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
        sums = shares(w.reshape(-1, 3), alphas.ravel(), index)
        found.append(sums.reshape(-1, *alphas.shape))
    reflected, passed, along = np.moveaxis(np.array(found, np.float64), 1, 0)
    means = (
        hemisphere_mean(table, etas, entered=entered)
        for entered in (False, True)
        for table in (reflected, passed)
    )
    inside = along / np.maximum(passed, 1e-12)
    return Tables(*(x.astype(np.float32) for x in (reflected, passed, *means, inside)))


def shares(w: np.ndarray, alpha: Any, eta: float) -> np.ndarray:
    """Sums float32 (3, N) over the facets visible from directions w (N, 3), of light that hits one.

    Shares of the light that facets reflect and that they pass; and the second times the cosine of
    the transmitted light. Light that would hit a second facet is lost.

    alpha: GGX width or `Widths`, numbers or arrays (N,).
    """
    kinds, two = backend(), isinstance(alpha, Widths)
    sizes = np.array(FINE if eta < 1 else COARSE)
    turn, height, weight = facet_nodes(*(sizes * 5 // 8 if two else sizes))
    if not two:  # one half of the facets mirrors the other
        w, turn = np.stack([np.hypot(w[:, 0], w[:, 1]), 0 * w[:, 1], w[:, 2]], axis=-1), 0.5 * turn
    count, index, found = len(weight), dr.opaque(kinds.Float, eta), []  # one kernel for all indices
    rows = np.column_stack([w, *(np.broadcast_to(x, len(w)) for x in pair(alpha)[: 1 + two])])
    for start in range(0, len(w), CHUNK):
        part = rows[start : start + CHUNK].astype(np.float32).T
        x, y, z, *own = (dr.repeat(kinds.Float(np.ascontiguousarray(row)), count) for row in part)
        nodes = (kinds.Float(node.astype(np.float32)) for node in (turn, height, weight))
        u, v, share = (dr.tile(node, part.shape[1]) for node in nodes)
        wi, width = kinds.Array3f(x, y, z), Widths(*own) if two else own[0]
        cap = microfacet.stretched(wi, width)
        m = microfacet.cap_normal(cap, width, v * (1 + cap.z) - cap.z, u / (2 * math.pi))
        m = dr.normalize(m)
        facing = dr.clip(dr.dot(wi, m), 0, 1)
        reflectance, inside = fresnel.dielectric(facing, index, DRJIT)
        # The refracted direction, turned up
        below = wi / index - (facing / index - dr.maximum(inside, 0)) * m
        mirrored = share * _masking(2 * facing * m - wi, width)
        passed = share * (1 - reflectance) * _masking(below, width)
        terms = mirrored * reflectance, passed, passed * below.z
        sums = [dr.block_sum(term, count) for term in terms]
        dr.eval(sums)
        found.append([x.numpy() for x in sums])
    return np.concatenate(found, axis=1)


def _masking(w: Any, alpha: Any) -> Any:
    """Smith masking of directions; zero below the horizon."""
    above = type(w)(w.x, w.y, dr.maximum(w.z, 1e-6))
    return dr.select(w.z > 0, microfacet.smith_g1(above, alpha), 0)


@functools.cache
def facet_nodes(azimuths: int, heights: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Azimuths in [0, 2 pi) and heights in (0, 1) of the quadrature over visible facets (K,), and
    their weights (K,), of sum one.

    A height of zero is the steepest facet. The nodes are dense there, because the steep facets
    determine the loss: only few of them reflect light above the horizon. The azimuths are shifted
    from height to height, so that no step of the values lies between the same nodes of all heights.
    """
    row = np.repeat(np.arange(heights), azimuths)
    shift = (row * 0.6180339887498949 + 0.5) % 1
    turn = (np.tile(np.arange(azimuths), heights) + shift) * (2 * np.pi / azimuths)
    root = (row + 0.5) / heights
    return turn, root * root, root / root.sum()
