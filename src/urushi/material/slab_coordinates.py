"""Coordinates of tables of transmitted light: of pairs of directions on both sides of a slab.

A pair is wi above the slab and the mirror image of wo below it, both as they would be in the denser
of the two outer media (`slabs.straight`). Light that goes straight through is then a narrow lobe at
small half angles. In the coordinates of `urushi.core.table`, a sign of w says which of both
cosines is the larger. f of importance is the table times the square of the index on wo's side, and
exchanging wi and wo leaves the table's value the same.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from urushi.checks import MIN_INDEX_STEP
from urushi.core import fresnel, microfacet
from urushi.core.namespace import NUMPY, Components, Namespace
from urushi.core.table import (
    MIN_COSINE,
    SHAPE,
    Knots,
    coordinates,
    interpolated_nodes,
    knots_of,
    knotted,
    known_nodes,
    node_directions,
    unknotted,
)
from urushi.walk import slabs

#: Nodes of a table of transmitted light: w has a sign.
PASSED_SHAPE = (*SHAPE[:2], 2 * SHAPE[2] - 1)

#: The node in v from which on light in the denser medium does not leave it.
CONE = 22

#: Values [1/sr] below which lobes inside a slab count little.
DIFFUSE = 0.1

#: Alpha and eta of the first interface on either side.
Faces = tuple[tuple[float, float], tuple[float, float]]

#: Index of the medium above, width, and eta of interfaces inside a slab.
InnerLobes = Sequence[tuple[float, float, float]]


def grazing_factor(above: Any, below: Any, faces: Faces, xp: Namespace) -> Any:
    """About the share of light that enters denser layers, which is steep near the horizon.

    It is a factor of transmitted light. The other factor is smooth, and so is its table, also where
    refraction bends all light of the horizon into a cone.
    """
    result = 1 + 0 * above.z
    for w, (alpha, eta) in zip((above, below), faces, strict=True):
        if eta > 1:
            tilted = xp.sqrt(w.z * w.z + float(alpha) ** 2 * (1 - w.z * w.z))
            result = result * (1 - fresnel.dielectric(tilted, float(eta), xp)[0])
    return result


def mirrored_inside(above: Any, other: Any, lobes: Sequence[Sequence[Any]], xp: Namespace) -> Any:
    """About the light that interfaces inside a slab mirror.

    It is a factor of the light that the slab reflects. The other factor is smooth, and so is its
    table, where lobes are narrow and at angles of total reflection.

    Args:
        above, other: directions on one side of the slab.
        lobes: `Layers.inner_lobes` of that side.
    """
    result = DIFFUSE + 0 * above.z
    for index, alpha, eta in lobes:
        a, b = (slabs.straight(w, index, xp) for w in (above, other))
        # Zero beyond total reflection above, and smooth
        x, y = ((w.x * w.x + w.y * w.y) / (index * index) for w in (above, other))
        reached = xp.maximum(1 - x, 0) * xp.maximum(1 - y, 0)
        h = microfacet.half_vector(a, b, xp)
        shape = microfacet.lobe_shape(alpha, a, b, h, xp)
        mirrored = fresnel.dielectric(microfacet.facet_cosine(h, xp), eta, xp)[0]
        result = result + reached * shape * mirrored
    return result


def passed_coordinates(above: Any, below: Any, index: float, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates in [0, 1] of pairs of directions above a slab and below it, both with z > 0.

    index: below the slab relative to above.
    """
    ratio = max(index, 1 / index)
    a, b = _refracted(above, below, index, ratio, xp)
    both, apart = Components(a.x + b.x, a.y + b.y, a.z + b.z), Components(None, None, a.z - b.z)
    u, v, w = coordinates(both, apart, xp)
    if knots := _passed_knots(
        ratio
    ):  # within the cone that leaves, v is in proportion to v outside
        edge = knots[0][0]
        v = knotted(xp.where(v < edge, edge * _refracted_v(v, ratio, xp), v), knots, xp)
    return u, v, 0.5 + xp.where(apart.z > 0, 0.5, -0.5) * w


def _refracted_v(v: Any, ratio: float, xp: Namespace) -> Any:
    """The coordinate v of the angle to which that of another v is refracted."""
    cosine = 1 - v * v
    square = 1 - ratio * ratio * (1 - cosine) * (1 + cosine)
    return xp.safe_sqrt(xp.maximum(1 - xp.safe_sqrt(xp.maximum(square, 0)), 0))


def _passed_knots(ratio: float) -> Knots:
    """The knots of a table of transmitted light; ratio: of the indices outside."""
    return knots_of([1 / ratio], CONE) if ratio > 1 + MIN_INDEX_STEP else ()


def _refracted(above: Any, below: Any, index: float, ratio: float, xp: Namespace) -> tuple:
    """The pair with that of its directions refracted that is in the less dense medium.

    ratio: index to which it is refracted relative to its own; its inverse undoes that.
    """
    if abs(index - 1) < MIN_INDEX_STEP:
        return above, below
    if index > 1:
        return slabs.straight(above, ratio, xp), below
    return above, slabs.straight(below, ratio, xp)


def passed_node_pairs(index: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions above and below, (N, 3) float32, of the nodes of a table of transmitted light."""
    u, v, w = (np.linspace(0, 1, count) for count in PASSED_SHAPE)
    ratio = max(index, 1 / index)
    if knots := _passed_knots(ratio):
        v, edge = unknotted(v, knots), knots[0][0]
        v = np.where(v < edge, _refracted_v(np.minimum(v / edge, 1), 1 / ratio, NUMPY), v)
    u, v, w = (x.ravel() for x in np.meshgrid(u, v, 2 * w - 1, indexing="ij"))
    low, high = node_directions(u, v, np.abs(w))
    pair = [Components(*np.where(w[:, None] > 0, *p).T) for p in ((high, low), (low, high))]
    found = []
    for x, y, z in _refracted(pair[0], pair[1], index, 1 / ratio, NUMPY):
        raised = np.stack([x, y, np.maximum(z, MIN_COSINE)], axis=1)
        found.append((raised / np.linalg.norm(raised, axis=1, keepdims=True)).astype(np.float32))
    return found[0], found[1]


def tabulated(f: Callable[..., np.ndarray], index: float, symmetric: bool = False) -> np.ndarray:
    """Values (*`PASSED_SHAPE`, C) of a function of directions above and below (N, 3)."""
    half, knots = SHAPE[2] if symmetric else PASSED_SHAPE[2], _passed_knots(max(index, 1 / index))
    rows = np.ix_(*known_nodes(knots), np.arange(half))
    pairs = (w.reshape(*PASSED_SHAPE, 3)[rows].reshape(-1, 3) for w in passed_node_pairs(index))
    values = f(*pairs)
    shape = [row.size for row in rows]
    result = interpolated_nodes(values.reshape(*shape, -1), knots)
    if symmetric:
        result = np.concatenate([result, result[:, :, half - 2 :: -1]], axis=2)
    return result
