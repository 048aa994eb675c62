"""Light that slabs transmit, as a function of directions above and below.

Light that goes straight through n rough interfaces is a mean over paths, with a direction in each
medium between them. One interface of a path is given by the directions on its two sides; those
above it are drawn from above, and those below it from below. Every interface serves as the given
one, and the balance heuristic combines all (Veach and Guibas 1995). The media attenuate a path,
which counts light that smooth interfaces mirror to and fro.

All other light is scattered by media or reflected by rough interfaces. It is computed by adding and
doubling (`urushi.material.adding`).
"""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core import lanes
from urushi.core.lanes import Lane
from urushi.core.namespace import DRJIT
from urushi.material import adding
from urushi.material.crossing import GENERATORS, cross, crossing_at, facet_points, in_plane
from urushi.material.slab_shares import Layers
from urushi.material.substrate import OnGrid

#: Paths of straight light for each interface that is given.
PATHS = 512

#: Facets at which light of a direction is refracted, and elevations outside.
FACETS, ELEVATIONS = 256, 48

#: Least width of straight light, as a mirror of this width reflects: a table holds no narrower one.
LEAST_SPREAD = MIN_ALPHA / 8


def transmitted(
    layers: Layers, insides: list[OnGrid], above: np.ndarray, below: np.ndarray, channels: int
) -> np.ndarray:
    """f / index^2 (N, C) [1/sr] of transmission for float32 directions (N, 3), both with z > 0.

    Args:
        layers: the slab.
        insides: what lies below each of its media.
    """
    values, outside, attenuations = _scattered(layers, insides, channels)
    straight = _straight(layers, attenuations, above, below, channels)
    return straight + np.maximum(outside.interpolated(values, above, below), 0)


def _scattered(
    layers: Layers, insides: list[OnGrid], channels: int
) -> tuple[np.ndarray, adding.Grid, list[np.ndarray]]:
    """All but straight light.

    Returns:
        f / index^2 [1/sr], values (N, N, H, C) on a grid, and the grid; and the shares (M, C) of
        straight light at `adding.MIRROR_COSINES` that cross the media.
    """
    indices, interfaces = layers.indices(), layers.interfaces
    outside = adding.Grid(layers.edges(-1 if indices[-1] > 1 else 0), ELEVATIONS)
    if not insides:
        return np.zeros((*outside.dots().shape, channels)), outside, []
    grids = [adding.grid(below.edges) for below in insides]
    alpha, eta = interfaces[-1]
    # Light from below that arrives above the interfaces that have been passed, all and straight
    every = [_crossing_modes(outside, grids[-1], alpha, 1 / eta)] * channels
    direct, attenuations = every, list[np.ndarray]()
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
        attenuations.insert(0, adding.interreflection(depths, upper, below.mirrored)[0])
        if level:
            above = grids[level - 1]
            crossing = functools.partial(_crossing_modes, own=above, alpha=alpha, eta=1 / eta)
            inner = own.averaged(crossing, adding.FINE_MODES)
            every, direct = ([modes @ inner for modes in x] for x in (every, direct))
    inwards = _crossing_modes(outside, own, alpha, eta)
    scattered = [
        own.mirror[:, None, None] * (inwards @ ((a - b) / own.weights).swapaxes(1, 2))
        for a, b in zip(every, direct, strict=True)
    ]
    values = np.stack([outside.values_of_modes(modes) for modes in scattered], axis=-1)
    values /= indices[1] ** 2
    return values, outside, attenuations


def _crossing_modes(outside: adding.Grid, own: adding.Grid, alpha: float, eta: float) -> np.ndarray:
    """Modes (H, M, N): shares of light of M directions outside that arrive at N nodes inside.

    eta: inside over outside; 1: light goes on.
    """
    if eta == 1:
        return np.stack([own.shares(outside.angles)] * len(own.azimuths))
    seen = in_plane(outside.cosines.astype(np.float32)[:, None])
    crossing = cross(seen, alpha, eta, facet_points(FACETS))
    return own.received(crossing.inside, crossing.weight / FACETS)


def _straight(
    layers: Layers,
    attenuations: Sequence[np.ndarray],
    above: np.ndarray,
    below: np.ndarray,
    channels: int,
) -> np.ndarray:
    """f / index^2 (N, C) [1/sr] of straight light; attenuations: as `_scattered` returns them."""
    first, last = np.flatnonzero(layers.interfaces[:, 1] != 1)[[0, -1]]
    widths, inner = _facets(layers)[first : last + 1], int(last - first)
    media = slice(int(first == 0), inner + len(layers.interfaces) - last)  # of a path's directions
    left = np.concatenate([np.ones((1, channels), np.float32), *attenuations])
    _, distinct, which = np.unique(left, axis=1, return_index=True, return_inverse=True)
    paths = PATHS if inner else 1

    def value(lane: Lane) -> Any:
        start, end = lane.directions()
        end = type(end)(-end.x, -end.y, end.z)  # where straight light from `start` goes
        media_left = [lane.nearest(x.T[distinct]) for x in attenuations]
        columns = np.repeat(widths[..., None], len(distinct), axis=-1)
        facets = [(lane.number(alpha), lane.number(eta)) for alpha, eta in columns]
        u, total = lane.lattice(paths, GENERATORS[PATHS], numbers=2 * inner), 0.0
        for given in range(inner + 1):
            down, up, crosses = [start], [end], start.z > 0
            for k in range(given):
                drawn = cross(down[-1], *facets[k], u[2 * k : 2 * k + 2], DRJIT)
                down, crosses = [*down, drawn.inside], crosses & (drawn.weight > 0)
            for k in range(inner, given, -1):
                alpha, eta = facets[k]
                drawn = cross(up[0], alpha, 1 / eta, u[2 * k - 2 : 2 * k], DRJIT)
                up, crosses = [drawn.inside, *up], crosses & (drawn.weight > 0)
            path = down + up
            f = _path_share(path, facets)
            for w, of_medium in zip(path[media], media_left, strict=True):
                f = f * of_medium(w.z)
            total = total + DRJIT.where(crosses, f, 0)
        return total / paths

    found = lanes.sums(value, len(distinct), (above, below), paths)
    return found[:, which.ravel()] / np.float32(layers.indices()[-1] ** 2)


def _path_share(path: list[Any], facets: list[tuple[Any, Any]]) -> Any:
    """f [1/sr] of a path over the sum of its densities, one for each given interface.

    With the weight w and the density d of each interface from above, and its density u from below,
    that is prod w over the cosine below and over the sum, for each given interface, of 1 / d times
    the quotients u / d of all interfaces below it.
    """
    weight, total = 1 / path[-1].z, 0.0
    for outside, inside, (alpha, eta) in zip(path[:-1], path[1:], facets, strict=True):
        down = crossing_at(outside, inside, alpha, eta, DRJIT)
        up = crossing_at(inside, outside, alpha, 1 / eta, DRJIT)
        weight = weight * down.weight
        total = (total * up.density + 1) / DRJIT.maximum(down.density, 1e-30)
    return DRJIT.where(weight > 0, weight / total, 0)


def _facets(layers: Layers) -> np.ndarray:
    """Width and index (n, 2) of each interface, for straight light.

    Widths are multiplied so that straight light has at least `LEAST_SPREAD`.
    """
    indices, (alphas, etas) = layers.indices(), layers.interfaces.T
    spread = np.sqrt(np.sum((0.5 * indices[:-1] * (etas - 1) * alphas) ** 2))
    factor = max(1.0, LEAST_SPREAD * max(indices[-1], 1) / spread)
    return np.stack([np.minimum(alphas * factor, 1), etas], axis=1)
