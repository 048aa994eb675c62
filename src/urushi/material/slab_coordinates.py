"""Coordinates of tables of transmitted light: of pairs of directions on both sides of a slab.

A pair is wi above the slab and the mirror image of wo below it. Light that goes straight through is
then a narrow lobe, which is round in the denser of the two outer media: its half angle there is the
coordinate u of `urushi.core.table`.

v and w are those of the pair after a stretch of both hemispheres by the angle to the normal. Light
within the cone that leaves the thinnest medium of the slab fills the same cone in both; within it,
the stretch is in proportion to v in the thinnest medium. Nodes are then as dense at the horizon of
this medium as in any table, although refraction packs it into few degrees of denser ones. w goes
from one end of what both directions can reach to the other, so that horizons are ends of cells.

f of importance is the table times the square of the index on wo's side, and exchanging wi and wo
leaves the table's value the same.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from urushi.checks import MIN_INDEX_STEP
from urushi.core import fresnel, microfacet, table
from urushi.core.namespace import NUMPY, Components, Namespace
from urushi.walk import slabs

#: Nodes of a table of transmitted light: w has a sign.
PASSED_SHAPE = (*table.SHAPE[:2], 2 * table.SHAPE[2] - 1)

#: The last node in v.
LAST = table.SHAPE[1] - 1

#: The least node in v at the edge of the cone, and its least distance from the last node.
CONE, BEYOND = 20, 2

#: Numbers in u by which the half angle of stretched pairs is inverted.
FINE = 256

#: Values [1/sr] below which lobes inside a slab count little.
DIFFUSE = 0.1

#: Indices of the media above and below a slab, relative to its thinnest medium.
Indices = tuple[float, float]

#: Alpha and eta of the first interface on either side.
Faces = Sequence[tuple[Any, Any]]

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
            tilted = xp.sqrt(w.z * w.z + alpha * alpha * (1 - w.z * w.z))
            result = result * (1 - fresnel.dielectric(tilted, eta, xp)[0])
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


def passed_coordinates(above: Any, below: Any, indices: Indices, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates in [0, 1] of pairs of directions above a slab and below it, both with z > 0."""
    a, b = (_stretched(w, n, indices, xp) for w, n in zip((above, below), indices, strict=True))
    both, apart = Components(a.x + b.x, a.y + b.y, a.z + b.z), Components(None, None, a.z - b.z)
    across = both.x * both.x + both.y * both.y
    squared = across + both.z * both.z
    reach = xp.safe_sqrt(xp.maximum(across / squared * (1 - 0.25 * squared), 0))
    low, high = _range(0.5 * both.z, reach, indices, xp)
    place = (apart.z - low - high) / xp.maximum(high - low, 1e-9)
    far = 1 - xp.safe_sqrt(xp.maximum(1 - xp.absolute(place), 0))
    v = table.coordinates(both, apart, xp)[1]
    return _half_angle(above, below, indices, xp), v, 0.5 + xp.where(place > 0, 0.5, -0.5) * far


def _half_angle(above: Any, below: Any, indices: Indices, xp: Namespace) -> Any:
    """The coordinate u of a pair, in the denser of the outer media."""
    a, b = (
        w if n == max(indices) else slabs.straight(w, max(indices) / n, xp)
        for w, n in zip((above, below), indices, strict=True)
    )
    x, y, z = a.x + b.x, a.y + b.y, a.z + b.z
    return table.log_tangent((x * x + y * y) / xp.maximum(z * z, 1e-18), xp)


def _edge(indices: Indices) -> int:
    """The node in v at the edge of the stretched cone; the last one without a thinner medium."""
    if max(indices) < 1 + MIN_INDEX_STEP:
        return LAST
    return min(max(CONE, round(LAST * table.v_of_sine(1 / max(indices)))), LAST - BEYOND)


def _range(mean: Any, reach: Any, indices: Indices, xp: Namespace) -> tuple[Any, Any]:
    """The ends of half the difference of both stretched cosines.

    Args:
        mean: of both cosines.
        reach: largest value of half the difference without horizons.
    """
    edge = _edge(indices) / LAST
    horizon = 1 - edge * edge
    above, below = (horizon if n < 1 + MIN_INDEX_STEP else 0.0 for n in indices)
    low = xp.minimum(xp.maximum(-reach, above - mean), reach)
    return low, xp.maximum(xp.minimum(reach, mean - below), -reach)


def _stretched(w: Any, index: float, indices: Indices, xp: Namespace) -> Any:
    """A stretched direction of an outer medium."""
    edge = _edge(indices) / LAST
    if edge == 1:
        return w
    sine2 = w.x * w.x + w.y * w.y
    refracted2 = index * index * sine2
    part = (edge * index) ** 2 / (1 + xp.safe_sqrt(xp.maximum(1 - refracted2, 0)))  # of v^2
    if index > 1 + MIN_INDEX_STEP:
        first = table.v_of_sine(1 / index)
        v = edge + (xp.safe_sqrt(xp.maximum(1 - w.z, 0)) - first) * ((1 - edge) / (1 - first))
        part = xp.where(refracted2 < 1, part, v * v / xp.maximum(sine2, 1 / index**2))
    v2 = part * sine2
    factor = xp.safe_sqrt(xp.maximum(part * (2 - v2), 0))
    return type(w)(w.x * factor, w.y * factor, 1 - v2)


def _unstretched(w: Components, index: float, indices: Indices) -> np.ndarray:
    """Unit vectors (N, 3), the inverse of `_stretched`, raised to `MIN_COSINE`."""
    edge = _edge(indices) / LAST
    sine2 = w.x * w.x + w.y * w.y
    v = np.sqrt(sine2 / (1 + w.z))
    inner = 1 - np.minimum(v / edge, 1) ** 2
    z = np.sqrt(1 - (1 - inner * inner) / index**2)
    if index > 1 + MIN_INDEX_STEP:
        first = table.v_of_sine(1 / index)
        beyond = first + (v - edge) * ((1 - first) / (1 - edge))
        z = np.where(v > edge, 1 - beyond * beyond, z)
    z = np.maximum(z, table.MIN_COSINE)
    factor = np.sqrt((1 - z * z) / np.maximum(sine2, 1e-30))
    return np.stack([w.x * factor, w.y * factor, z], axis=1)


@functools.lru_cache(maxsize=4)
def passed_node_pairs(indices: Indices) -> tuple[np.ndarray, np.ndarray]:
    """Directions above and below, (N, 3) float32, of the nodes of a table of transmitted light."""
    u, v, w = (np.linspace(0, 1, count) for count in PASSED_SHAPE)
    places = np.broadcast_to(u[:, None], (u.size, v.size * w.size))
    if max(indices) >= 1 + MIN_INDEX_STEP:  # the half angle grows with that of the stretched pair
        fine = np.linspace(0, 1, FINE)
        fine_u, fine_v, fine_w = (x.ravel() for x in np.meshgrid(fine, v, w, indexing="ij"))
        above, below = (Components(*x.T) for x in _pairs(fine_u, fine_v, fine_w, indices))
        found = _half_angle(above, below, indices, NUMPY)
        columns = np.maximum.accumulate(found.reshape(FINE, -1)).T
        places = np.stack([np.interp(u, column, fine) for column in columns], axis=-1)
    _, v, w = np.meshgrid(u, v, w, indexing="ij")
    a, b = _pairs(places.ravel(), v.ravel(), w.ravel(), indices)
    return a.astype(np.float32), b.astype(np.float32)


def _pairs(u: np.ndarray, v: np.ndarray, w: np.ndarray, indices: Indices) -> list[np.ndarray]:
    """Directions above and below, (N, 3); u: of stretched pairs."""
    cos_d, cos_h = 1 - v * v, 1 / np.sqrt(1 + np.maximum(table.squared_tangent(u), 1e-9))
    mean, reach = cos_h * cos_d, np.sqrt((1 - cos_h * cos_h) * (1 - cos_d * cos_d))
    low, high = _range(mean, reach, indices, NUMPY)
    place = np.sign(w - 0.5) * (1 - (1 - np.abs(2 * w - 1)) ** 2)
    apart = 0.5 * (low + high + place * (high - low))
    size = np.minimum(np.abs(apart) / np.maximum(np.minimum(mean, reach), 1e-9), 1)
    lower, higher = table.node_components(u, v, 1 - np.sqrt(1 - size), NUMPY)
    found = []
    for index, first in zip(indices, (apart > 0, apart <= 0), strict=True):
        own = Components(*(np.where(first, x, y) for x, y in zip(higher, lower, strict=True)))
        found.append(_unstretched(own, index, indices))
    return found


def tabulated(
    f: Callable[..., np.ndarray], indices: Indices, symmetric: bool = False
) -> np.ndarray:
    """Values (*`PASSED_SHAPE`, C) of a function of directions above and below (N, 3)."""
    half, node = table.SHAPE[2] if symmetric else PASSED_SHAPE[2], _edge(indices)
    knots = ((node / LAST, node),) if node < LAST else ()
    rows = np.ix_(*table.known_nodes(knots), np.arange(half))
    pairs = (w.reshape(*PASSED_SHAPE, 3)[rows].reshape(-1, 3) for w in passed_node_pairs(indices))
    values = f(*pairs)
    shape = [row.size for row in rows]
    result = table.interpolated_nodes(values.reshape(*shape, -1), knots)
    if symmetric:
        result = np.concatenate([result, result[:, :, half - 2 :: -1]], axis=2)
    return result
