"""Tables of slabs: the light that they reflect on either side, and the light that they transmit.

What a slab reflects on a side are coats over its last interface (`urushi.material.coated_table`).
Its first interface is a lobe beside the table, through the medium that lies above it if there is
one. What it transmits (`urushi.material.slab_light`) is a table, too.

A table is linear between its nodes, and the cells of a narrow lobe or of the horizon hold a few per
cent too little or too much light. Its logarithm is therefore changed by a sum of two functions of
the angles of both directions, by which f stays reciprocal, so that all light of a direction has the
share that adding finds on a fine grid (`urushi.material.slab_shares`).
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from urushi.core.namespace import NUMPY, Components, stacked
from urushi.core.quadrature import AZIMUTH_NODES, half_vector_rule
from urushi.core.table import (
    MAX_LOG,
    MIN_LOG,
    SHAPE,
    Knots,
    interpolated,
    interpolated_at,
    interpolated_columns,
    knots_of,
    node_pairs,
    pair_coordinates,
)
from urushi.material import adding
from urushi.material.coated_table import SLAB_POINTS, rest_at_nodes
from urushi.material.reflector import Reflector
from urushi.material.slab_coordinates import (
    Faces,
    Indices,
    InnerLobes,
    grazing_factor,
    mirrored_inside,
    passed_coordinates,
    passed_node_pairs,
    tabulated,
)
from urushi.material.slab_light import transmitted
from urushi.material.slab_shares import Layers, Shares, shares
from urushi.material.substrate import OnGrid, Substrate
from urushi.nets import lobe as lobes
from urushi.walk import slabs

#: Angles at which the light of a table is known, and their distances [rad] from angles of total
#: reflection, beside which there are two more.
ANGLES = 0.495 * np.pi * np.sin(np.linspace(0, 0.5 * np.pi, 24))
BESIDE_EDGES = np.array([0.012, 0.04])

#: Nodes of the quadrature of this light in each half of the azimuth's range.
AROUND = 8

#: Rounds by which it is found, and a share of the light that does not matter.
ROUNDS, STEP, SMALL = 8, 0.75, 0.002

#: Largest change of a logarithm by the angle of one direction.
LARGEST_CHANGE = 1.0


class Reflected(NamedTuple):
    """What a slab of C channels reflects on a side, without the lobe of its first interface."""

    table: np.ndarray  # float16 (*`SHAPE`, C) logarithms of f
    knots: Knots  # of the table


class SlabTables(NamedTuple):
    """A slab of C channels."""

    reflected: tuple[Reflected, Reflected]  # above and below it, divided by `mirrored_inside`
    # float16 (*`PASSED_SHAPE`, C) logarithms of f of transmission, divided by the squared index on
    # wo's side and by `grazing_factor` of both directions
    passed: np.ndarray
    indices: Indices  # of the media above and below, relative to its thinnest medium
    faces: Faces  # alpha and eta of the first interface on each side
    depths: np.ndarray  # (2, C) optical depths of the media on each side of the interfaces
    inner: tuple[InnerLobes, InnerLobes]  # the lobes of `mirrored_inside` on each side

    @property
    def eta(self) -> float:
        """The index below relative to that above."""
        return self.indices[1] / self.indices[0]

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (N, C) [1/sr] of importance, see `simulate`, for unit vectors (N, 3) on any side."""
        result = np.empty((len(wi), self.passed.shape[-1]))
        a, b = (np.concatenate([w[:, :2], np.abs(w[:, 2:])], axis=1) for w in (wi, wo))
        for lower, crosses in np.ndindex(2, 2):
            at = (wi[:, 2] < 0) == lower
            at &= (wi[:, 2] * wo[:, 2] < 0) == crosses
            if not at.any():
                continue
            if not crosses:
                lobe = lobes.of_coat(*map(np.float64, self.faces[lower]))
                surface = lobes.f(lobe, a[at], b[at])[:, None]
                left = np.exp(-self.depths[lower] * (1 / a[at, 2] + 1 / b[at, 2])[:, None])
                directions = Components(*a[at].T), Components(*b[at].T)
                factor = mirrored_inside(*directions, self.inner[lower], NUMPY)[:, None]
                table, knots = self.reflected[lower]
                result[at] = interpolated(table, a[at], b[at], knots) * factor + surface * left
                continue
            pair = (b[at], a[at]) if lower else (a[at], b[at])
            above, below = (Components(*w.T) for w in pair)
            values = interpolated_at(
                self.passed, *passed_coordinates(above, below, self.indices, NUMPY)
            )
            scale = grazing_factor(above, below, self.faces, NUMPY)[:, None]
            result[at] = values * scale * (1 if lower else self.eta**2)
        return result

    def powers(self, wi: np.ndarray, azimuths: int = AZIMUTH_NODES) -> list[tuple]:
        """Light of unit vectors (N, 3) that is reflected and transmitted, in M directions.

        azimuths: of `half_vector_rule`.

        Returns:
            For either: tangents (N, M) of half angles, about where a mirror or straight light goes,
            and shares of the light (N, M, C).
        """
        sign, found = np.where(wi[:, 2] < 0, -1.0, 1.0), []
        near = Components(wi[:, 0], wi[:, 1], np.abs(wi[:, 2]))
        for seen, side in ((near, sign), (slabs.straight(near, self.eta**sign, NUMPY), -sign)):
            about = stacked(seen)
            wo, weights = half_vector_rule(about, azimuths=azimuths)
            half, power = wo + about[:, None], weights * wo[..., 2]
            wo[..., 2] *= side[:, None]
            f = self.f(np.repeat(wi, wo.shape[1], axis=0), wo.reshape(-1, 3))
            tangents = np.hypot(half[..., 0], half[..., 1]) / half[..., 2]
            found.append((tangents, f.reshape(*power.shape, -1) * power[..., None]))
        return found

    def shares(self, wi: np.ndarray) -> np.ndarray:
        """Shares (2, N, C) of the light of unit vectors (N, 3): reflected and transmitted."""
        return np.array([power.sum(axis=1) for _, power in self.powers(wi)])


def slab_tables(interfaces: np.ndarray, media: np.ndarray) -> SlabTables:
    """The tables of a slab.

    Args:
        interfaces: (n + 1, 2) alpha and eta, top to bottom, each relative to the medium above. The
            index of one of them at least is not 1.
        media: (n, 3, C) albedo, sigma_t and g between them.
    """
    layers, channels = Layers.of(interfaces, media), media.shape[-1]
    turned = layers.turned()
    symmetric = np.allclose(turned.interfaces, layers.interfaces, 1e-4) and all(
        a.shape == b.shape and np.allclose(a, b)
        for a, b in zip(turned.media, layers.media, strict=True)
    )
    faces, relative = (layers.face(), turned.face()), layers.indices() / layers.indices().min()
    indices = float(relative[0]), float(relative[-1])
    sides = [shares(side, channels) for side in (layers, turned)[: 1 if symmetric else 2]]
    above, insides = _reflected(layers, sides[0])
    below = above if symmetric else _reflected(turned, sides[1])[0]

    def light(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        known = grazing_factor(Components(*a.T), Components(*b.T), faces, NUMPY)
        return transmitted(layers, insides, a, b, channels) / known[:, None]

    logs = np.log(np.maximum(tabulated(light, indices, symmetric), 1e-30))
    heights = [np.arccos(w[:, 2]) for w in passed_node_pairs(indices)]
    passed_light = [_passed_light(x[0], indices, faces, side) for side, x in enumerate(sides)]
    logs = _with_light(logs, heights, passed_light)
    passed = logs.clip(MIN_LOG, MAX_LOG).astype(np.float16)
    depths = np.stack([layers.depth(channels), turned.depth(channels)])
    inner = layers.inner_lobes(), turned.inner_lobes()
    return SlabTables((above, below), passed, indices, faces, depths, inner)


class Light(NamedTuple):
    """The light of a table at M angles of one of both directions."""

    angles: np.ndarray  # (M,) ascending
    shares: np.ndarray  # (M, C) that it should have
    weights: np.ndarray  # (M, Q) of the quadrature
    places: list[np.ndarray]  # coordinates (M Q,) of its nodes

    def of(self, logs: np.ndarray) -> np.ndarray:
        """The shares (M, C) that a table has."""
        values = interpolated_at(logs, *self.places).reshape(*self.weights.shape, -1)
        return np.einsum("mq,mqc->mc", self.weights, values)


def _with_light(logs: np.ndarray, angles: list[np.ndarray], sides: list[Light]) -> np.ndarray:
    """A table (..., C) with the light of both directions' sides, or of the only one.

    angles: (N,) of both directions at its nodes.
    """
    changes, result = [np.zeros_like(side.shares) for side in sides], logs
    for _ in range(ROUNDS):
        for side, change in zip(sides, changes, strict=True):
            found = side.of(result)
            change += STEP * np.log((side.shares + SMALL) / (found + SMALL))
        total: np.ndarray | float = 0.0
        for k, own in enumerate(angles):
            side, change = sides[k % len(sides)], changes[k % len(sides)]
            change.clip(-LARGEST_CHANGE, LARGEST_CHANGE, out=change)
            total = total + interpolated_columns(own, side.angles, change)
        result = (logs + np.reshape(total, logs.shape)).astype(np.float32)
    return result


def _light(
    own: Shares,
    light: np.ndarray,
    seen: Callable[[Components], Components],
    known: Callable[[Components, Components], np.ndarray],
    places: Callable[[Components, Components], Sequence[np.ndarray]],
) -> Light:
    """The light of a table.

    Args:
        own, light: shares of a slab; those that the table should have, reflected or passed.
        seen: where light of a direction mostly goes, mirrored back.
        known: the factor of f that the table does not hold, of pairs of directions.
        places: coordinates of pairs in the table.
    """
    edges = np.array(own.edges)[:, None]
    close = (np.abs(ANGLES - edges) < 2 * BESIDE_EDGES[0]).any(axis=0)
    beside = np.concatenate([edges - BESIDE_EDGES, edges + BESIDE_EDGES], axis=1).ravel()
    angles = np.sort(np.concatenate([ANGLES[~close], beside]))
    angles = angles[(angles >= 0) & (angles <= ANGLES[-1])]
    near = Components(np.sin(angles), 0 * angles, np.cos(angles))
    far, weights = half_vector_rule(stacked(seen(near)), azimuths=AROUND)
    first = stacked(near)[:, None]
    pair = [Components(*w.reshape(-1, 3).T) for w in np.broadcast_arrays(first, far)]
    weights = weights * far[..., 2] * known(*pair).reshape(weights.shape)
    wanted = interpolated_columns(angles, own.angles, light)
    return Light(angles, wanted, weights, list(places(*pair)))


def _passed_light(own: Shares, indices: Indices, faces: Faces, side: int) -> Light:
    """The light of a table of transmission for directions above (side 0) or below (1)."""
    index = indices[1] / indices[0]
    ratio, scale = (1 / index, 1.0) if side else (index, index**2)

    def sides(a: Components, b: Components) -> tuple[Components, Components]:
        return (b, a) if side else (a, b)

    return _light(
        own,
        own.passed,
        lambda w: slabs.straight(w, ratio, NUMPY),
        lambda a, b: scale * grazing_factor(*sides(a, b), faces, NUMPY),
        lambda a, b: passed_coordinates(*sides(a, b), indices, NUMPY),
    )


def _reflected(layers: Layers, every: list[Shares]) -> tuple[Reflected, list[OnGrid]]:
    """What the slab reflects above, and what lies below its media.

    every: shares of what lies from each interface on, from the first to the last.
    """
    channels, insides, last = every[0].passed.shape[-1], list[OnGrid](), len(layers.media)
    interfaces = np.repeat(layers.interfaces[..., None], channels, axis=-1)
    logs = np.full((*SHAPE, channels), MIN_LOG, np.float16)
    knots = [knots_of(np.sin(layers.edges(level)).tolist()) for level in range(last + 1)]
    for level in reversed(range(last)):
        edges, lobe = layers.edges(level + 1), lobes.of_coat(*interfaces[level + 1])
        reflector = Reflector.of_logs(logs, lobe, knots=knots[level + 1])._replace(darkened=False)
        if insides:
            inside = OnGrid.of(reflector, edges)
        else:
            surface = layers.interfaces[-1, 0], 1 / layers.interfaces[-1, 1], edges
            modes = np.stack([adding.interface_modes(*surface)] * channels)
            inside = OnGrid(edges, modes, adding.mirror(*surface).repeat(channels, axis=1))
        insides.insert(0, inside)
        own, known = Substrate.of(reflector, inside), knots[level]
        if layers.interfaces[level, 1] == 1:  # the lobe below is seen beside the table
            own = replace(own, reflector=reflector._replace(lobe=reflector.lobe[:, :0]))
        inner = Layers(layers.interfaces[level:], layers.media[level:]).inner_lobes()
        mirrored = functools.partial(mirrored_inside, lobes=inner, xp=NUMPY)
        pairs = node_pairs(known)
        factor = mirrored(*(Components(*w.T) for w in pairs)).astype(np.float32).reshape(SHAPE)
        media, columns = layers.media[level].reshape(-1, channels), factor.reshape(-1, 1)
        rest = rest_at_nodes(
            own, np.arange(channels), interfaces[level], media, columns, SLAB_POINTS, known
        )
        places = functools.partial(_places, knots=known)
        side = _light(every[level], every[level].reflected, lambda w: w, mirrored, places)
        logs = np.log(np.maximum(rest.reshape(logs.shape), 1e-30))
        logs = _with_light(logs, [np.arccos(w[:, 2]) for w in pairs], [side])
        if level:
            logs = logs + np.log(factor)[..., None]
        logs = logs.clip(MIN_LOG, MAX_LOG).astype(np.float16)
    return Reflected(logs, knots[0]), insides


def _places(a: Components, b: Components, knots: Knots) -> tuple[np.ndarray, ...]:
    """The coordinates of pairs in a table of reflection."""
    return pair_coordinates(stacked(a), stacked(b), knots)
