"""Tables of slabs: the light that they reflect on either side, and the light that they transmit.

What a slab reflects on a side are coats over its last interface (`urushi.material.coated_table`).
What it transmits is tabulated at wi above it and the mirror image of wo below, both as they would
be in the denser of the two outer media (`slabs.straight`). Light that goes straight through is then
a narrow lobe at small half angles. In the coordinates of `urushi.material.table`, a sign of w says
which of both cosines is the larger. f of importance is the table times the square of the index on
wo's side, and exchanging wi and wo leaves the table's value the same.

Light of the directions wi', after refraction at random facets of the topmost interface, meets

    1 / eta^2 E[w_i w_o S(wi', wo')] + E[w_i a(wi') t(wi', wo)],

S being light that the medium scatters or rough interfaces reflect, by adding and doubling
(`urushi.material.adding`), w the transmitted fractions (`urushi.material.crossing`), t the straight
light of all lower layers, a table too, and a the attenuation of the medium, which counts light that
smooth interfaces mirror to and fro. Below the last medium, t is the lowest interface itself: its
directions are drawn from both sides.
"""

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, MIN_INDEX_STEP, CoatParameters
from urushi.core import fresnel
from urushi.core.namespace import NUMPY, Components, Namespace
from urushi.core.quadrature import half_vector_rule
from urushi.material import adding, energy
from urushi.material.coated_table import (
    COSINES,
    ROWS,
    HalfVectors,
    Inside,
    coated_table,
    half_vectors,
    least_factors,
    sums,
)
from urushi.material.crossing import LEAST_COSINE, Vector, cross, crossing_at, facet_points
from urushi.material.material import Material
from urushi.material.table import (
    SHAPE,
    Knots,
    completed,
    coordinates,
    interpolated,
    interpolated_at,
    knots_of,
    knotted,
    known_nodes,
    node_directions,
    unknotted,
)
from urushi.nets import lobe as lobes
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.features import MIN_COSINE
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks
from urushi.walk import slabs

#: Nodes of a table of transmitted light: w has a sign.
PASSED_SHAPE = (*SHAPE[:2], 2 * SHAPE[2] - 1)

#: The node in v from which on light in the denser medium does not leave it.
CONE = 22

#: Directions inside for each node, drawn from either side.
STRAIGHT = 34

#: The same where one of the sides is a table.
THROUGH_TABLE = 64

#: Facets at which light of a direction is refracted, and elevations outside.
FACETS, ELEVATIONS = 256, 48

#: Cosines near the horizon, below the first, at which a table is given all light; least and largest
#: logarithm of the factor; rounds of the search for it.
GRAZING, MISSING, ROUNDS = np.array([0.5, 0.35, 0.2, 0.1, 0.04]), (-0.5, 1.0), 8

#: Nodes of the quadrature of this light in each half of the azimuth's range.
AROUND = 4

#: Least width of straight light, as a mirror of this width reflects: a table holds no narrower one.
LEAST_SPREAD = MIN_ALPHA / 5

#: The share (..., C) of light that is left of cosines (...).
Attenuation = Callable[[np.ndarray], np.ndarray]


#: Alpha and eta of the first interface on either side.
Faces = tuple[tuple[float, float], tuple[float, float]]


class SlabTables(NamedTuple):
    """A slab of C channels.

    Attributes:
        reflected: above it and below it.
        passed: float16 (*`PASSED_SHAPE`, C) logarithms of f / index^2 of transmission, of the index
            on wo's side, over `entering` of both directions.
        eta: index below it relative to above.
        faces: alpha and eta of the first interface on each side.
    """

    reflected: tuple[Material, Material]
    passed: np.ndarray
    eta: float
    faces: Faces

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (N, C) [1/sr] of importance for unit vectors (N, 3) on any side."""
        result = np.empty((len(wi), self.passed.shape[-1]))
        a, b = (np.concatenate([w[:, :2], np.abs(w[:, 2:])], axis=1) for w in (wi, wo))
        for lower, crosses in np.ndindex(2, 2):
            at = (wi[:, 2] < 0) == lower
            at &= (wi[:, 2] * wo[:, 2] < 0) == crosses
            if not at.any():
                continue
            if not crosses:
                result[at] = self.reflected[lower].f(a[at], b[at])
                continue
            pair = (b[at], a[at]) if lower else (a[at], b[at])
            above, below = (Components(*w.T) for w in pair)
            values = interpolated_at(
                self.passed, *passed_coordinates(above, below, self.eta, NUMPY)
            )
            scale = entering(above, below, self.faces, NUMPY)[:, None]
            result[at] = values * scale * (1 if lower else self.eta**2)
        return result

    def powers(self, wi: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Light of a unit vector (3,) that is reflected and transmitted, at directions M.

        Returns:
            For either: tangents (M,) of half angles, about where a mirror or straight light goes,
            and shares of the light (M, C).
        """
        sign, found = float(np.sign(wi[2])), []
        near = Components(*(wi * [1, 1, sign]))
        for seen, side in ((near, sign), (slabs.straight(near, self.eta**sign, NUMPY), -sign)):
            wo, weights = half_vector_rule(np.array([seen]))
            f = self.f(np.broadcast_to(wi, wo[0].shape), wo[0] * [1, 1, side])
            half = wo[0] + np.array(seen)
            tangents = np.hypot(half[:, 0], half[:, 1]) / half[:, 2]
            found.append((tangents, f * (weights[0] * wo[0, :, 2])[:, None]))
        return found

    def shares(self, wi: np.ndarray) -> np.ndarray:
        """Shares (2, N, C) of the light of unit vectors (N, 3): reflected and transmitted."""
        every = [[power.sum(axis=0) for _, power in self.powers(w)] for w in wi]
        return np.array(every).swapaxes(0, 1)


def slab_tables(model: Model, interfaces: np.ndarray, media: np.ndarray) -> SlabTables:
    """The tables of a slab.

    Args:
        model: isotropic networks, of which nothing is used but the form of the codes.
        interfaces: (n + 1, 2) alpha and eta, top to bottom, each relative to the medium above.
        media: (n, 3, C) albedo, sigma_t and g between them.
    """
    turned = np.stack([interfaces[:, 0], 1 / interfaces[:, 1]], axis=1)[::-1]
    symmetric = np.allclose(turned, interfaces, 1e-4) and np.allclose(media[::-1], media)
    above, layers = _reflected(model, interfaces, media)
    below = above if symmetric else _reflected(model, turned, media[::-1])[0]
    index, faces = float(interfaces[:, 1].prod()), (tuple(interfaces[0]), tuple(turned[0]))
    light = transmitted(interfaces, media, layers, faces)
    logs = np.log(np.maximum(_tabulated(light, index, media.shape[-1], symmetric), 1e-30))
    logs = _completed(light, logs, index, faces, symmetric)
    passed = logs.clip(MIN_LOG, MAX_LOG).astype(np.float16)
    tables = SlabTables((above, below), passed, index, faces)
    upper = _limited(tables, 1)
    return tables._replace(reflected=(upper, upper if symmetric else _limited(tables, -1)))


def _completed(
    light: Callable[..., np.ndarray], logs: np.ndarray, index: float, faces: Faces, symmetric: bool
) -> np.ndarray:
    """A table of transmitted light with all light near the horizon, which few of its cells hold.

    Args:
        light: as of `transmitted`.
        logs: (*`PASSED_SHAPE`, C) its logarithms at the nodes.
        index, faces: as of `SlabTables`.
        symmetric: whether both sides are the same.
    """
    sides = [side for side in range(2 - symmetric) if faces[side][1] > 1]
    quadratures = []
    for side, cosine in itertools.product(sides, GRAZING[1:]):
        near = Components((1 - cosine**2) ** 0.5, 0.0, cosine)
        seen = slabs.straight(near, index ** (1 - 2 * side), NUMPY)
        far, weights = (x[0] for x in half_vector_rule(np.array([seen]), azimuths=AROUND))
        pair = [np.full(far.shape, near, np.float32), far.astype(np.float32)][:: 1 - 2 * side]
        values = np.empty((len(far), logs.shape[-1]), np.float32)
        fill_blocks(values, light, *pair, rows=ROWS)
        a, b = (Components(*w.T) for w in pair)
        weights = weights * far[:, 2] * entering(a, b, faces, NUMPY)
        places = passed_coordinates(a, b, index, NUMPY)
        quadratures.append((weights @ values, weights, places))
    heights = [-w[:, 2] for w in _node_pairs(index)]
    factors = np.zeros((2, len(GRAZING), logs.shape[-1]))
    result = logs
    for _ in range(ROUNDS if sides else 0):
        changes = [np.log(x / (w @ interpolated_at(result, *p))) for x, w, p in quadratures]
        factors[sides, 1:] += np.reshape(changes, (len(sides), -1, logs.shape[-1]))
        factors = factors.clip(*MISSING)
        if symmetric:
            factors[1] = factors[0]
        above, below = (
            np.stack([np.interp(z, -GRAZING, column) for column in factor.T], axis=-1)
            for z, factor in zip(heights, factors, strict=True)
        )
        result = logs + np.where(abs(above) > abs(below), above, below).reshape(logs.shape)
    return result


def _limited(tables: SlabTables, side: int) -> Material:
    """What is reflected above (1) or below (-1): with transmitted light, no more than all light."""
    wi = np.stack([np.sqrt(1 - COSINES**2), 0 * COSINES, side * COSINES], axis=1)
    material, every = tables.reflected[side < 0], tables.shares(wi.astype(np.float32)).sum(axis=0)
    table = material.table
    assert table is not None  # for the type checker
    rest = adding.albedos(lambda a, b: interpolated(table, a, b, material.knots), COSINES)
    factors = 1 - np.maximum(every - 1, 0) / np.maximum(rest, energy.LEAST_ALBEDO)
    logs = np.log(least_factors(factors.clip(0.5, 1), material.knots)).reshape(table.shape)
    return replace(material, table=(table + logs).clip(MIN_LOG).astype(np.float16))


def entering(above: Any, below: Any, faces: Faces, xp: Namespace) -> Any:
    """A factor of transmitted light that is steep near the horizon: what enters denser layers.

    A table of the rest is smooth, also where refraction bends all light of the horizon into a cone.
    """
    result = 1 + 0 * above.z
    for w, (alpha, eta) in zip((above, below), faces, strict=True):
        if eta > 1:
            tilted = xp.sqrt(w.z * w.z + float(alpha) ** 2 * (1 - w.z * w.z))
            result = result * (1 - fresnel.dielectric(tilted, float(eta), xp)[0])
    return result


def passed_coordinates(above: Any, below: Any, index: float, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates in [0, 1] of pairs of directions above a slab and below it, both with z > 0.

    index: below the slab relative to above.
    """
    ratio = max(index, 1 / index)
    above, below = _refracted(above, below, index, ratio, xp)
    return _denser_coordinates(above, below, ratio, xp)


def _denser_coordinates(a: Any, b: Any, ratio: float, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates of pairs of directions in the denser medium; ratio: of the indices outside.

    Within the cone of light that leaves that medium, v is in proportion to v outside.
    """
    both, apart = Components(a.x + b.x, a.y + b.y, a.z + b.z), Components(None, None, a.z - b.z)
    u, v, w = coordinates(both, apart, 1, xp)
    if knots := _passed_knots(ratio):
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


def _node_pairs(index: float) -> tuple[np.ndarray, np.ndarray]:
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


def _reflected(
    model: Model, interfaces: np.ndarray, media: np.ndarray
) -> tuple[Material, list[Inside]]:
    """What the slab reflects above, and each of its media."""
    channels, lobe = media.shape[-1], slice(model.arch.lobe)
    below, layers = None, list[Inside]()
    for level in reversed(range(len(interfaces))):
        alpha, eta = np.broadcast_to(interfaces[level], (channels, 2)).T
        codes = np.zeros((channels, model.arch.latent), np.float32)
        codes[:, lobe] = lobes.of_coat(alpha, eta)
        table = np.full((*SHAPE, channels), MIN_LOG, np.float16)
        knots = knots_of(np.sin(_edges(interfaces, level - 1)).tolist())
        if below is not None:
            edges = _edges(interfaces, level)
            if layers:
                own, modes = adding.grid(edges), adding.bottom_modes(below.f, edges)
                mirrored = own.at_cosines(np.stack([own.mirror_shares(m) for m in modes], axis=-1))
            else:
                surface = interfaces[-1, 0], 1 / interfaces[-1, 1], edges
                modes = np.stack([adding.interface_modes(*surface)] * channels)
                mirrored = adding.mirror(*surface).repeat(channels, axis=1)
            layers.insert(0, Inside(edges, modes, mirrored, knots))
            coat = CoatParameters(alpha, eta, *media[level])
            table = coated_table(below, coat, codes[:, lobe], layers[0])
        below = Material(codes, model, table=table, beside_lobe=True, knots=knots)
    assert below is not None  # for the type checker
    return below, layers


def _edges(interfaces: np.ndarray, level: int) -> adding.Edges:
    """Angles of total reflection inside a medium, or beyond the last one: of every other index."""
    indices = np.append(1, interfaces[:, 1].cumprod())
    sines = indices / indices[level + 1]
    return tuple(np.unique(np.arcsin(sines[sines < 1 - 1e-6]).round(4)).tolist())


def transmitted(
    interfaces: np.ndarray,
    media: np.ndarray,
    layers: list[Inside],
    faces: Faces,
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """f / index^2 [1/sr] of transmission over `entering`: a function of directions above and below.

    Args:
        interfaces, media: as of `slab_tables`.
        layers: the media.
        faces: as of `SlabTables`.
    """
    indices = interfaces[:, 1].cumprod()
    edges = [_edges(interfaces, level) for level in range(-1, len(interfaces))]
    outside = adding.Grid(ELEVATIONS, edges=edges[-1 if indices[-1] > 1 else 0])
    facets = _facets(interfaces, indices)
    alpha, eta = interfaces[-1]
    # Light from below that arrives above the interfaces that have been passed, all and straight
    crossing = _crossing_modes(outside, adding.grid(edges[-2]), alpha, 1 / eta)
    every = [crossing] * media.shape[-1]
    direct, table = every, None
    for level in reversed(range(len(media))):
        inside, own = edges[level + 1], adding.grid(edges[level + 1])
        alpha, eta = interfaces[level]
        back = adding.interface_modes(alpha, eta, inside)
        fields, straights, depths = zip(
            *(
                adding.passed_inside(modes, back, medium, inside)
                for modes, medium in zip(layers[level].modes, media[level].T, strict=True)
            ),
            strict=True,
        )
        every = [a @ b for a, b in zip(every, fields, strict=True)]
        direct = [a * b for a, b in zip(direct, straights, strict=True)]
        upper = adding.mirror(alpha, eta, inside)
        attenuation, _ = adding.to_and_fro(depths, upper, layers[level].mirrored)
        straight = _two_interfaces(facets[level], facets[-1], indices[level], attenuation)
        if table is not None:
            index = indices[-1] / indices[level]
            straight = _one_interface(facets[level], table, index, attenuation)
        if level:
            above = adding.grid(edges[level])
            inner = own.averaged(
                functools.partial(_crossing_modes, own=above, alpha=alpha, eta=1 / eta)
            )
            every, direct = ([modes @ inner for modes in x] for x in (every, direct))
            index = indices[-1] / indices[level - 1]
            table = np.log(np.maximum(_tabulated(straight, index, media.shape[-1]), 1e-30))
    inwards = _crossing_modes(outside, own, alpha, eta)
    scattered = [
        own.mirror[:, None, None] * (inwards @ ((a - b) / own.weights).swapaxes(1, 2))
        for a, b in zip(every, direct, strict=True)
    ]
    values = np.stack([outside.values_of_modes(modes) for modes in scattered], axis=-1)
    values /= indices[0] ** 2

    def whole(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        every = straight(wi, wo) + np.maximum(outside.interpolated(values, wi, wo), 0)
        return every / entering(Components(*wi.T), Components(*wo.T), faces, NUMPY)[:, None]

    return whole


def _tabulated(
    f: Callable[..., np.ndarray], index: float, channels: int, symmetric: bool = False
) -> np.ndarray:
    """Values (*`PASSED_SHAPE`, C) of a function of directions above and below (N, 3)."""
    half, knots = SHAPE[2] if symmetric else PASSED_SHAPE[2], _passed_knots(max(index, 1 / index))
    rows = np.ix_(*known_nodes(knots), np.arange(half))
    shape = [row.size for row in rows]
    pairs = (w.reshape(*PASSED_SHAPE, 3)[rows].reshape(-1, 3) for w in _node_pairs(index))
    values = np.empty((math.prod(shape), channels), np.float32)
    fill_blocks(values, f, *pairs, rows=ROWS)
    result = completed(values.reshape(*shape, channels), knots)
    if symmetric:
        result = np.concatenate([result, result[:, :, half - 2 :: -1]], axis=2)
    return result


def _facets(interfaces: np.ndarray, indices: np.ndarray) -> list[tuple[float, float]]:
    """Width and index of each interface, for straight light: an index of 1 is nearly one.

    Widths are multiplied so that straight light has at least `LEAST_SPREAD`.
    """
    above = indices / interfaces[:, 1]
    spread = np.sqrt(np.sum((0.5 * above * (interfaces[:, 1] - 1) * interfaces[:, 0]) ** 2))
    factor = max(1.0, LEAST_SPREAD * max(indices[-1], 1) / spread)
    return [
        (float(min(alpha * factor, 1)), float(eta)) if eta != 1 else (MIN_ALPHA, 1 + MIN_INDEX_STEP)
        for alpha, eta in interfaces
    ]


def _crossing_modes(outside: adding.Grid, own: adding.Grid, alpha: float, eta: float) -> np.ndarray:
    """Modes (H, M, N): shares of light of M directions outside that arrive at N nodes inside.

    eta: inside over outside; 1: light goes on.
    """
    if eta == 1:
        return np.stack([own.shares(outside.angles)] * len(own.azimuths))
    u = facet_points(FACETS)
    inside = cross(outside.cosines.astype(np.float32)[:, None], alpha, eta, u)
    x, y, z = inside.inside
    shares = own.shares(np.arccos(np.clip(z, 0, 1)))
    turn = np.arctan2(y, x)
    modes = []
    for order in range(len(own.azimuths)):
        weight = inside.weight * np.cos(order * turn) / FACETS
        modes.append(np.einsum("mk,mkn->mn", weight, shares))
    return np.stack(modes)


def _turn(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine (N, 1) of the azimuth of directions (N, 3)."""
    turn = np.arctan2(w[:, 1], w[:, 0])[:, None]
    return np.cos(turn), np.sin(turn)


def _two_interfaces(
    upper: tuple[float, float], lower: tuple[float, float], index: float, attenuation: Attenuation
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Straight light through two interfaces: a function of directions (N, 3), f (N, C).

    Args:
        upper, lower: alpha, and eta relative to the medium above.
        index: of the medium between them.
        attenuation: of that medium.

    Half of the directions inside are drawn from either side, weighted by the balance heuristic.
    """
    u = facet_points(STRAIGHT)
    lower = lower[0], 1 / lower[1]

    def straight(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        total: np.ndarray | float = 0.0
        for one, other, own, far in ((above, below, upper, lower), (below, above, lower, upper)):
            a = cross(one[:, 2, None], *own, u)
            (cos, sin), (x, y, z) = _turn(one), a.inside
            inside: Vector = (sin * y - cos * x, -cos * y - sin * x, z)  # mirrored
            b = crossing_at(tuple(other[:, i, None] for i in range(3)), inside, *far)
            chances = a.density * b.density / np.maximum(a.density + b.density, np.float32(1e-30))
            weight = (a.weight * b.weight * chances / (z * STRAIGHT)).ravel()
            present = np.flatnonzero(weight)
            values = attenuation(z.take(present)) * weight.take(present)[:, None]
            total = total + sums(values, present // STRAIGHT, len(above))
        return np.asarray(total) / np.float32(index * index)

    return straight


def _one_interface(
    facets: tuple[float, float], logs: np.ndarray, index: float, attenuation: Attenuation
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Straight light through an interface and the layers below: a function as of `_two_interfaces`.

    Args:
        facets: alpha and eta of the interface.
        logs: float32 (*`PASSED_SHAPE`, C) of the straight light of the layers.
        index: below the layers relative to the medium between.
        attenuation: of that medium.

    Half of the directions inside are drawn by the interface, half by half vectors of the layers.
    """
    u = facet_points(THROUGH_TABLE)
    peak: HalfVectors = half_vectors(np.exp(logs), 1.0)
    half = peak.draw(u[:, ::-1].astype(np.float64))
    index = float(index)  # in single precision
    ratio = max(index, 1 / index)

    def straight(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        (cos, sin), columns = _turn(above), [below[:, i, None] for i in range(3)]
        (x, y, z), weight, _ = cross(above[:, 2, None], *facets, u)
        drawn = Components(cos * x - sin * y, sin * x + cos * y, z)
        _, far = _refracted(drawn, Components(*columns), index, ratio, NUMPY)
        dot = sum(w * h for w, h in zip(far, half, strict=True))
        mirrored = Components(*(2 * dot * h - w for w, h in zip(far, half, strict=True)))
        seen, _ = _refracted(mirrored, far, index, 1 / ratio, NUMPY)
        reached = (dot > 0) & (mirrored.z > 0) & (index * np.hypot(mirrored.x, mirrored.y) < 1)
        present = np.concatenate([weight > 0, reached], axis=1)
        inside = tuple(np.concatenate(w, axis=1) for w in zip(drawn, seen, strict=True))
        chosen = np.flatnonzero(present & (inside[2] > LEAST_COSINE))
        rows = chosen // present.shape[1]
        inside = tuple(w.take(chosen) for w in inside)
        far = Components(*(w.take(rows) for w in far))
        b = crossing_at(tuple(above[:, i].take(rows) for i in range(3)), inside, *facets)
        denser, _ = _refracted(Components(*inside), far, index, ratio, NUMPY)
        places = _denser_coordinates(denser, far, ratio, NUMPY)
        both = [p + q for p, q in zip(denser, far, strict=True)]
        chance = peak.density_at(places[0]) / (2 * np.sqrt(sum(w * w for w in both)))
        if index > 1:  # solid angles of refracted directions
            chance = chance * inside[2] / (index * index * denser.z)
        share = b.weight * b.density / np.maximum(b.density + chance, np.float32(1e-30))
        values = interpolated_at(logs, *places) * attenuation(inside[2])
        return sums(values * share[:, None], rows, len(above)) / THROUGH_TABLE

    return straight
