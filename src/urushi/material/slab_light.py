"""Light that slabs transmit, as a function of directions above and below.

Light of the directions wi', after refraction at random facets of the topmost interface, meets

    1 / eta^2 E[w_i w_o S(wi', wo')] + E[w_i a(wi') t(wi', wo)],

S being light that the media scatter or rough interfaces reflect, by adding and doubling
(`urushi.material.adding`), w the transmitted fractions (`urushi.material.crossing`), t the straight
light of all lower layers, a table too, and a the attenuation of the media, which counts light that
smooth interfaces mirror to and fro. Below the last medium, t is the lowest interface itself: its
directions are drawn from both sides. Light straight through a single interface is known.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core.namespace import NUMPY, Components
from urushi.core.table import SHAPE, interpolated_at, squared_tangent
from urushi.material import adding
from urushi.material.crossing import (
    LEAST_COSINE,
    Vector,
    cross,
    crossing_at,
    facet_points,
    in_plane,
    sums,
)
from urushi.material.slab_coordinates import (
    Faces,
    denser_coordinates,
    grazing_factor,
    refracted,
    tabulated,
)
from urushi.material.slab_shares import Layers
from urushi.material.substrate import OnGrid

#: Directions inside for each node, drawn from either side.
STRAIGHT = 34

#: The same where one of the sides is a table.
THROUGH_TABLE = 64

#: Facets at which light of a direction is refracted, and elevations outside.
FACETS, ELEVATIONS = 256, 48

#: Least width of straight light, as a mirror of this width reflects: a table holds no narrower one.
LEAST_SPREAD = MIN_ALPHA / 8

#: Nodes in a table's v of the mean over half vectors: difference angles up to 45 degrees.
PEAK_NODES = 17

#: The share (..., C) of light that is left of cosines (...).
Attenuation = Callable[[np.ndarray], np.ndarray]


class HalfVectors(NamedTuple):
    """The distribution of half vectors of a bottom, constant in solid angle between nodes in u."""

    cosines: np.ndarray  # (U,) of the half angle at the nodes
    cumulated: np.ndarray  # (U,) shares of the half vectors up to each node
    density: np.ndarray  # float32 (U - 1,) [1/sr] between nodes

    def draw(self, u: np.ndarray) -> Vector:
        """Half vectors (K,) from numbers u (K, 2) in [0, 1)."""
        cosine = np.interp(u[:, 0], self.cumulated, self.cosines)
        sine, phi = np.sqrt(np.maximum(1 - cosine * cosine, 0)), 2 * np.pi * u[:, 1]
        x, y, z = (w.astype(np.float32) for w in (sine * np.cos(phi), sine * np.sin(phi), cosine))
        return x, y, z

    def density_at(self, u: np.ndarray) -> np.ndarray:
        """Density (N,) [1/sr] at the table's coordinates u (N,)."""
        last = len(self.density) - 1
        return self.density[np.clip(u * (last + 1), 0, last).astype(np.intp)]


def transmitted(
    layers: Layers, insides: list[OnGrid], faces: Faces, channels: int
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """f / index^2 [1/sr] of transmission divided by `grazing_factor`, a function of wi and wo.

    Args:
        layers: the slab.
        insides: what lies below each of its media.
        faces: of `grazing_factor`.
    """
    scattered, attenuations = _scattered(layers, insides, channels)
    straight = _straight(layers, attenuations, channels)

    def whole(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        every = straight(wi, wo) + np.maximum(scattered(wi, wo), 0)
        return every / grazing_factor(Components(*wi.T), Components(*wo.T), faces, NUMPY)[:, None]

    return whole


def _scattered(
    layers: Layers, insides: list[OnGrid], channels: int
) -> tuple[Callable[[np.ndarray, np.ndarray], np.ndarray | float], list[Attenuation]]:
    """f / index^2 [1/sr] of all but straight light, and the attenuations of the media."""
    if not insides:
        return lambda wi, wo: 0.0, []
    indices, interfaces = layers.indices(), layers.interfaces
    grids = [adding.grid(below.edges) for below in insides]
    outside = adding.Grid(ELEVATIONS, edges=layers.edges(-1 if indices[-1] > 1 else 0))
    alpha, eta = interfaces[-1]
    # Light from below that arrives above the interfaces that have been passed, all and straight
    every = [_crossing_modes(outside, grids[-1], alpha, 1 / eta)] * channels
    direct, attenuations = every, list[Attenuation]()
    for level, (below, own) in reversed(list(enumerate(zip(insides, grids, strict=True)))):
        (alpha, eta), edges = interfaces[level], below.edges
        back, media = adding.interface_modes(alpha, eta, edges), layers.media[level]
        fields, straights, depths = zip(
            *(
                adding.passed_inside(modes, back, media[..., channel], edges)
                for channel, modes in enumerate(below.modes)
            ),
            strict=True,
        )
        every = [a @ b for a, b in zip(every, fields, strict=True)]
        direct = [a * b for a, b in zip(direct, straights, strict=True)]
        upper = adding.mirror(alpha, eta, edges)
        crossing = adding.interreflection(depths, upper, below.mirrored)[0]
        attenuations.insert(0, adding.nearest(crossing))
        if level:
            above = grids[level - 1]
            inner = own.averaged(
                functools.partial(_crossing_modes, own=above, alpha=alpha, eta=1 / eta)
            )
            every, direct = ([modes @ inner for modes in x] for x in (every, direct))
    inwards = _crossing_modes(outside, own, alpha, eta)
    scattered = [
        own.mirror[:, None, None] * (inwards @ ((a - b) / own.weights).swapaxes(1, 2))
        for a, b in zip(every, direct, strict=True)
    ]
    values = np.stack([outside.values_of_modes(modes) for modes in scattered], axis=-1)
    values /= indices[1] ** 2
    return functools.partial(outside.interpolated, values), attenuations


def _straight(
    layers: Layers, attenuations: list[Attenuation], channels: int
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """f / index^2 [1/sr] of straight light; attenuations: of the media between interfaces."""
    first, last = np.flatnonzero(layers.interfaces[:, 1] != 1)[[0, -1]]
    indices, facets = layers.indices(), _facets(layers)
    straight = _single_interface(facets[last], indices[-1], channels)
    for level in reversed(range(first, last)):
        index, attenuation = indices[level + 1], attenuations[level]
        if level == last - 1:
            straight = _two_interfaces(facets[level], facets[last], index, attenuation)
            continue
        ratio = indices[-1] / index
        logs = np.log(np.maximum(tabulated(straight, ratio, channels), 1e-30))
        straight = _one_interface(facets[level], logs, ratio, attenuation)

    def whole(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        value = straight(above, below)
        if first > 0:  # media outside the interfaces
            value = value * attenuations[0](above[:, 2])
        if last < len(facets) - 1:
            value = value * attenuations[-1](below[:, 2])
        return value

    return whole


def _facets(layers: Layers) -> list[tuple[float, float]]:
    """Width and index of each interface, for straight light.

    Widths are multiplied so that straight light has at least `LEAST_SPREAD`.
    """
    indices, (alphas, etas) = layers.indices(), layers.interfaces.T
    spread = np.sqrt(np.sum((0.5 * indices[:-1] * (etas - 1) * alphas) ** 2))
    factor = max(1.0, LEAST_SPREAD * max(indices[-1], 1) / spread)
    return [(float(min(alpha * factor, 1)), float(eta)) for alpha, eta in layers.interfaces]


def _single_interface(
    facets: tuple[float, float], index: float, channels: int
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Straight light through one interface: a function as of `_two_interfaces`."""

    def straight(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        outside = tuple(above.T)
        inside = -below[:, 0], -below[:, 1], below[:, 2]  # mirrored
        crossing = crossing_at(outside, inside, *facets)
        f = crossing.weight * crossing.density / (below[:, 2] * np.float32(index * index))
        return np.repeat(f[:, None], channels, axis=1)

    return straight


def _crossing_modes(outside: adding.Grid, own: adding.Grid, alpha: float, eta: float) -> np.ndarray:
    """Modes (H, M, N): shares of light of M directions outside that arrive at N nodes inside.

    eta: inside over outside; 1: light goes on.
    """
    if eta == 1:
        return np.stack([own.shares(outside.angles)] * len(own.azimuths))
    u = facet_points(FACETS)
    inside = cross(in_plane(outside.cosines.astype(np.float32)[:, None]), alpha, eta, u)
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
            a = cross(in_plane(one[:, 2, None]), *own, u)
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


def _half_vectors(f: np.ndarray) -> HalfVectors:
    """The distribution of half vectors at which values f (U, ...) at a table's nodes are bright."""
    tan2 = np.maximum(squared_tangent(np.linspace(0, 1, SHAPE[0])), 0)
    cosines = 1 / np.sqrt(1 + tan2)
    size = f[:, :PEAK_NODES].mean(axis=(1, 2, 3), dtype=np.float64)
    angles = 2 * np.pi * (cosines[:-1] - cosines[1:])
    shares = (size[:-1] + size[1:]) * (cosines[:-1] + cosines[1:]) * angles
    shares /= shares.sum()
    cumulated = np.concatenate([[0], np.cumsum(shares)])
    return HalfVectors(cosines, cumulated, (shares / angles).astype(np.float32))


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
    peak = _half_vectors(np.exp(logs))
    half = peak.draw(u[:, ::-1].astype(np.float64))
    index = float(index)  # in single precision
    ratio = max(index, 1 / index)

    def straight(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        (cos, sin), columns = _turn(above), [below[:, i, None] for i in range(3)]
        (x, y, z), weight, _ = cross(in_plane(above[:, 2, None]), *facets, u)
        drawn = Components(cos * x - sin * y, sin * x + cos * y, z)
        _, far = refracted(drawn, Components(*columns), index, ratio, NUMPY)
        dot = sum(w * h for w, h in zip(far, half, strict=True))
        mirrored = Components(*(2 * dot * h - w for w, h in zip(far, half, strict=True)))
        seen, _ = refracted(mirrored, far, index, 1 / ratio, NUMPY)
        reached = (dot > 0) & (mirrored.z > 0) & (index * np.hypot(mirrored.x, mirrored.y) < 1)
        present = np.concatenate([weight > 0, reached], axis=1)
        inside = tuple(np.concatenate(w, axis=1) for w in zip(drawn, seen, strict=True))
        chosen = np.flatnonzero(present & (inside[2] > LEAST_COSINE))
        rows = chosen // present.shape[1]
        inside = tuple(w.take(chosen) for w in inside)
        far = Components(*(w.take(rows) for w in far))
        b = crossing_at(tuple(above[:, i].take(rows) for i in range(3)), inside, *facets)
        denser, _ = refracted(Components(*inside), far, index, ratio, NUMPY)
        places = denser_coordinates(denser, far, ratio, NUMPY)
        both = [p + q for p, q in zip(denser, far, strict=True)]
        chance = peak.density_at(places[0]) / (2 * np.sqrt(sum(w * w for w in both)))
        if index > 1:  # solid angles of refracted directions
            chance = chance * inside[2] / (index * index * denser.z)
        share = b.weight * b.density / np.maximum(b.density + chance, np.float32(1e-30))
        values = interpolated_at(logs, *places) * attenuation(inside[2])
        return sums(values * share[:, None], rows, len(above)) / THROUGH_TABLE

    return straight
