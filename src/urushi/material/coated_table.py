"""Tables of coats over materials that have a table, by light transport through the coat.

A code is too coarse for a measured BRDF, and a coat over the code inherits its error. Light
transport below the coat's interface is therefore computed without networks. f of the coated
material, without the lobe of its interface, is

    1 / eta^2 E[w_i w_o S(wi', wo')],

where wi' and wo' are wi and wo after refraction at random facets of the interface, w_i and w_o the
transmitted fractions (`urushi.material.crossing`), and S is the BRDF of everything below, seen from
just below the interface: the bottom through the medium, and all light that the medium scatters or
that the interface reflects back (`urushi.material.adding`). Light that smooth surfaces mirror to
and fro stays in the narrow lobe of the bottom.

An index of 1 is no interface, and f is S itself.

The mean is a sum over 256 fixed pairs wi', wo', 64 in slabs. Under a rough coat, few of them would
hit a narrow lobe of the bottom. Twice as many are therefore drawn from one of them and a half
vector of the bottom's lobe, and the balance heuristic combines all (Veach and Guibas 1995). A sixth
of the nodes is computed; between them, logarithms are cubic (`table.completed`).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.namespace import NUMPY, Components
from urushi.core.table import (
    HIGHEST,
    LOWEST,
    SHAPE,
    TAN2_OFFSET,
    Knots,
    completed,
    coordinates,
    interpolated,
    interpolated_at,
    known_nodes,
    node_pairs,
    pair_coordinates,
    table_of_values,
)
from urushi.material import adding, energy
from urushi.material.crossing import (
    LEAST_COSINE,
    Crossing,
    Vector,
    cross,
    crossing_at,
    facet_pair_points,
)
from urushi.material.material import Material
from urushi.nets import lobe as lobes
from urushi.parallel import fill_blocks

#: Half vectors are drawn in proportion to this power of the bottom's mean f over the half angle.
#: The mean itself would spend most of them on wide lobes, which the interface's pairs sample as
#: well. In slabs, rough interfaces between similar media widen light less than their facets do.
PEAK_POWER, SLAB_POWER = 2.0, 1.5

#: Nodes in the table's v of that mean: difference angles up to 45 degrees, as below a coat.
PEAK_NODES = 17

#: Root mean square of the relative deviation of a channel from a sum of others that stands for it,
#: about the rounding of a table in half precision.
SPANNED = 2e-3

#: Nodes of a table that are computed at once: their numbers stay in a core's cache.
ROWS = 256

#: Cosines at which the albedo is limited.
COSINES = np.array([1.0, 0.9, 0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01])

#: Rounds of that limit.
ROUNDS = 4


class Inside(NamedTuple):
    """The medium of a coat."""

    edges: adding.Edges  # of its medium
    modes: np.ndarray  # (C, H, N, N) of what lies below the medium
    mirrored: np.ndarray  # (M, C) shares of light at `adding.COSINES` that it mirrors
    knots: Knots  # of the table of the coated material
    media: np.ndarray  # (k, 3, C) albedo, sigma_t and g
    factor: np.ndarray  # float32 (U, V, W) of f at the nodes; f over it is smooth between them


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
        """Density [1/sr] at the table's coordinate u."""
        last = len(self.density) - 1
        return self.density[np.clip(u * (last + 1), 0, last).astype(np.intp)]


class Below(NamedTuple):
    """The BRDF of everything below an interface, for channels C that share the interface."""

    # float32 (U, V, W, 2 C), ln f of the bottom without its lobes, and of light that medium or
    # interface turn back
    table: np.ndarray
    lobe: np.ndarray | None  # float32 (C, N) of the bottom, (1, N) if the channels share it
    depth: np.ndarray  # float32 (C,) the optical depth that attenuates light from the lobe
    # Factor of each direction of light from the bottom, the root of `adding.to_and_fro`.
    times: Callable[[np.ndarray], np.ndarray]
    peak: HalfVectors  # of the bottom
    knots: Knots  # of the table


def coated_rest(bottom: Material, coat: CoatParameters, slab: Inside | None = None) -> np.ndarray:
    """f float32 (N, C) [1/sr] at the nodes of a coated material without the interface's lobe.

    Args:
        bottom: a material with a table, of C or one channel.
        coat: numbers or arrays (C,), with one width.
        slab: of a coat of a slab, which has the media instead.
    """
    knots = slab.knots if slab else ()
    every, rows = node_pairs(1, knots), np.ix_(*known_nodes(knots))
    known = tuple(w.reshape(*SHAPE, 3)[rows].reshape(-1, 3) for w in every)
    points = facet_pair_points(64 if slab else 256)
    parameters = np.stack([*np.broadcast_arrays(*coat, np.zeros(bottom.channels))][:5])
    result = np.empty((len(every[0]), parameters.shape[1]), np.float32)
    values = bottom.f(*node_pairs(1, bottom.knots)).reshape(*SHAPE, -1)
    inside = slab or _opaque(bottom, parameters[2:])
    parameters = np.concatenate([parameters[:2], inside.media.reshape(-1, parameters.shape[1])])
    peak = half_vectors(values, SLAB_POWER if slab else PEAK_POWER)
    for interface in np.unique(parameters[:2], axis=1).T:
        chosen = np.flatnonzero((parameters[:2] == interface[:, None]).all(axis=0))
        own = np.minimum(chosen, bottom.channels - 1)
        first, which = _distinct(bottom, own, parameters[2:, chosen])
        media = parameters[2:, chosen[first]]
        under = _below(bottom, own[first], interface, media, peak, inside)
        below, weights = _spanning(under)
        pairs = every if interface[1] == 1 else known  # without an interface, a pair costs little
        values = np.empty((len(pairs[0]), len(weights)), np.float32)
        fill_blocks(
            values,
            lambda *pair, below=below, interface=interface: _crossed(
                below, points, *interface, *pair
            ),
            *pairs,
            rows=ROWS,
        )
        if pairs is known:
            shape = *(row.size for row in rows), *SHAPE[2:], -1
            values = completed(values.reshape(shape) / inside.factor[rows][..., None], knots)
            values = (values * inside.factor[..., None]).reshape(len(result), -1)
        values = values @ weights
        result[:, chosen] = values[:, which]
    return result


def _opaque(bottom: Material, medium: np.ndarray) -> Inside:
    """A coat over an opaque bottom; medium: (3, C)."""
    own, modes = adding.grid(), adding.bottom_modes(bottom.f)
    mirrored = own.at_cosines(np.stack([own.mirror_shares(m) for m in modes], axis=-1))
    return Inside((), modes, mirrored, (), medium[None], np.ones(SHAPE, np.float32))


def _distinct(
    bottom: Material, channels: np.ndarray, media: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Indices (D,) of channels (C,) under media (3 k, C) that differ, and the place (C,) of each
    channel among them. A grey material is computed once."""
    assert bottom.table is not None  # for the type checker
    known: dict[tuple[bytes, ...], int] = {}
    first: list[int] = []
    which: list[int] = []
    for index, (channel, medium) in enumerate(zip(channels, media.T, strict=True)):
        parts = bottom.table[..., channel], bottom.latents[channel], medium
        key = tuple(part.tobytes() for part in parts)
        if key not in known:
            known[key] = len(first)
            first.append(index)
        which.append(known[key])
    return np.array(first), np.array(which)


def coated_table(bottom: Material, coat: CoatParameters, lobe: np.ndarray) -> np.ndarray:
    """The table float16 (U, V, W, C) of a coated material, without the lobe of its interface.

    Table and lobe have a directional albedo of at most 1, or of at most the bottom's if the bottom
    gains energy.

    Args:
        bottom, coat: as of `coated_rest`.
        lobe: (C, N) of the interface. No table has it: near the horizon it changes too fast.
    """
    rest = coated_rest(bottom, coat)
    own = lobe.astype(np.float64)

    def top(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return lobes.f(own, wi[:, None].astype(np.float64), wo[:, None].astype(np.float64))

    of_rest = _albedos_of_values(rest)
    of_top = adding.albedos(top, COSINES)
    ceiling = np.full(rest.shape[1], 1 - energy.MARGIN)
    if (of_rest + of_top > ceiling).any():
        gained = adding.albedos(bottom.f, COSINES).max(axis=0)
        ceiling = np.where(gained > 1 + energy.TOLERANCE, gained, ceiling)
    allowed = np.maximum(ceiling - of_top, energy.LEAST_REST)
    for _ in range(ROUNDS):  # a factor at the nodes is a smaller change between them
        factors = np.minimum(allowed / np.maximum(of_rest, energy.LEAST_ALBEDO), 1)
        if (factors == 1).all():
            break
        rest *= _least_factors(factors)
        of_rest = _albedos_of_values(rest)
    return table_of_values(rest)


def _least_factors(factors: np.ndarray) -> np.ndarray:
    """The lesser (N, C) of both factors at `node_pairs`, of factors (M, C) at `COSINES`.

    It keeps f reciprocal.
    """
    columns = [
        np.minimum(*(np.interp(w[:, 2], COSINES[::-1], column[::-1]) for w in node_pairs()))
        for column in factors.T
    ]
    return np.stack(columns, axis=1).astype(np.float32)


def _albedos_of_values(f: np.ndarray) -> np.ndarray:
    """Albedos (N, C) at `COSINES` of the table of values f (M, C) at `node_pairs`."""
    table = table_of_values(f).astype(np.float32)
    return adding.albedos(lambda wi, wo: interpolated(table, wi, wo), COSINES)


def half_vectors(f: np.ndarray, power: float) -> HalfVectors:
    """The distribution of half vectors at which values f (U, ...) at a table's nodes are bright."""
    nodes = np.linspace(0, 1, SHAPE[0])
    tan2 = np.maximum(np.exp(LOWEST + nodes * (HIGHEST - LOWEST)) - TAN2_OFFSET, 0)
    cosines = 1 / np.sqrt(1 + tan2)
    size = f[:, :PEAK_NODES].mean(axis=(1, 2, 3), dtype=np.float64) ** power
    angles = 2 * np.pi * (cosines[:-1] - cosines[1:])
    shares = (size[:-1] + size[1:]) * (cosines[:-1] + cosines[1:]) * angles
    shares /= shares.sum()
    cumulated = np.concatenate([[0], np.cumsum(shares)])
    return HalfVectors(cosines, cumulated, (shares / angles).astype(np.float32))


def _below(
    bottom: Material,
    channels: np.ndarray,
    interface: np.ndarray,
    media: np.ndarray,
    peak: HalfVectors,
    inside: Inside,
) -> Below:
    """The BRDF below for channels (C,) of the bottom under media (3 k, C), all different."""
    assert bottom.table is not None  # for the type checker
    wi, wo = node_pairs(1, bottom.knots)
    edges, modes = inside.edges, inside.modes
    own, back = adding.grid(edges), adding.interface_modes(*interface, edges=edges)
    inverse = (1 / wi[:, 2] + 1 / wo[:, 2]).reshape(SHAPE)
    direct, more, depths = [], [], []
    for channel, medium in zip(channels, media.T, strict=True):
        layers = medium.reshape(-1, 3)
        again, depth = adding.seen_inside(modes[channel], back, layers, edges)
        more.append(own.interpolated(again[..., None], wi, wo).reshape(SHAPE))
        logs = bottom.table[..., channel].astype(np.float32) - depth * inverse
        direct.append(logs)
        depths.append(depth)
    upper = adding.mirror(float(interface[0]), float(interface[1]), edges)
    times = adding.to_and_fro(depths, upper, inside.mirrored[:, channels])[1]
    logs = np.log(np.maximum(np.stack(more, axis=-1), 1e-30))
    table = np.concatenate([np.stack(direct, axis=-1), logs], axis=-1, dtype=np.float32)
    lobe = None
    if bottom.beside_lobe:
        lobe = bottom.latents[channels, : bottom.model.arch.lobe]
        lobe = lobe[:1] if (lobe == lobe[:1]).all() else lobe
    return Below(table, lobe, np.array(depths, np.float32), times, peak, bottom.knots)


def _spanning(below: Below) -> tuple[Below, np.ndarray]:
    """Channels (D,), and weights (D, C) by which their sums are all channels, up to `SPANNED`.

    f of the coated material is linear in the BRDF below, so that fewer channels suffice for the
    bands of a spectrum. The next channel is always the farthest from sums of the chosen ones.
    """
    channels = len(below.depth)
    if channels <= 3:
        return below, np.eye(channels, dtype=np.float32)
    wi, wo = node_pairs(1, below.knots)
    s = _seen(below, wi, wo, pair_coordinates(wi, wo, 1, below.knots))
    relative = s / s.mean(axis=1, keepdims=True)
    sizes = np.linalg.norm(relative, axis=0)
    relative /= sizes
    left, chosen = relative.copy(), list[int]()
    while len(chosen) < channels:
        away = np.linalg.norm(left, axis=0)
        farthest = int(np.argmax(away))
        if away[farthest] < SPANNED:
            break
        chosen.append(farthest)
        axis = left[:, farthest] / away[farthest]
        left -= axis[:, None] * (axis @ left)
    weights = np.linalg.lstsq(relative[:, chosen], relative, rcond=None)[0]
    weights *= sizes / sizes[chosen, None]
    lobe = below.lobe if below.lobe is None or len(below.lobe) == 1 else below.lobe[chosen]
    part = below._replace(
        table=below.table[..., [*chosen, *(channels + np.array(chosen))]],
        lobe=lobe,
        depth=below.depth[chosen],
        times=lambda cosine: below.times(cosine)[..., chosen],
    )
    return part, weights.astype(np.float32)


def _crossed(
    below: Below, u: np.ndarray, alpha: float, eta: float, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """f float32 (N, C) of pairs (N, 3), without the interface's lobe (see the module).

    u: `facet_pair_points`.
    """
    if eta == 1:
        return _seen(below, wi, wo, pair_coordinates(wi, wo, 1, below.knots))
    cosines = wi[:, 2, None], wo[:, 2, None]
    cross_product = wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]
    turn = np.arctan2(cross_product, wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])[:, None]
    alpha, eta = float(np.float32(alpha)), float(np.float32(eta))
    a, b = (cross(c, alpha, eta, u[:, k : k + 2]) for c, k in zip(cosines, (0, 2), strict=True))
    count = len(wi)
    rows = np.repeat(np.arange(count), len(u))
    total = _weighted(below, a, b._replace(inside=_turned(b.inside, turn)), rows, count)
    for near, other, k in ((a, cosines[1], 2), (b, cosines[0], 0)):  # seen in a mirror, b is as a
        half = below.peak.draw(u[:, k : k + 2])
        dot = sum(x * h for x, h in zip(near.inside, half, strict=True))
        mirror = [2 * dot * h - x for x, h in zip(near.inside, half, strict=True)]
        reached = np.flatnonzero((near.weight > 0) & (dot > 0) & (mirror[2] > LEAST_COSINE))
        sine, own = np.sqrt(np.maximum(1 - other * other, 0)), rows.take(reached)
        outside = _turned((sine, np.zeros_like(sine), other), turn)
        outside, inside = (
            tuple(x.take(at) for x in w) for w, at in ((outside, own), (mirror, reached))
        )
        far = crossing_at(outside, inside, alpha, eta)
        total = total + _weighted(below, near.taken(reached), far, own, count)
    return total / (eta * eta * len(u))


def _weighted(below: Below, a: Crossing, b: Crossing, rows: np.ndarray, count: int) -> np.ndarray:
    """Sums (N, C) over pairs of crossings (M,), weighted by the balance heuristic.

    rows: (M,) places of the sums, below `count`.
    """
    weight = (a.weight * b.weight).ravel()
    present = np.flatnonzero(weight)  # in slabs a third of all
    weight, (a, b) = weight.take(present), (w.taken(present) for w in (a, b))
    x, y, z = (p + q for p, q in zip(a.inside, b.inside, strict=True))
    apart = Components(None, None, a.inside[2] - b.inside[2])
    places = coordinates(Components(x, y, z), apart, 1, NUMPY, below.knots)
    # Reflection about a half vector stretches solid angles by 4 cos theta_d.
    drawn = below.peak.density_at(places[0]) / (2 * np.sqrt(x * x + y * y + z * z))
    least = np.float32(1e-30)
    others = 1 / np.maximum(a.density, least) + 1 / np.maximum(b.density, least)
    wi, wo = (np.stack(w.inside, axis=-1) for w in (a, b))
    values = _seen(below, wi, wo, places) * (weight / (1 + drawn * others))[:, None]
    return sums(values, rows.take(present), count)


def sums(values: np.ndarray, rows: np.ndarray, count: int) -> np.ndarray:
    """Sums (N, C) of the values (M, C) of each row (M,), below `count`."""
    return np.stack([np.bincount(rows, column, count) for column in values.T], axis=-1)


def _seen(
    below: Below, wi: np.ndarray, wo: np.ndarray, places: tuple[np.ndarray, ...]
) -> np.ndarray:
    """The BRDF below (..., C) for pairs (..., 3) with table coordinates `places` (...)."""
    values = interpolated_at(below.table, *(p.ravel() for p in places))
    direct, more = np.split(values.reshape(*places[0].shape, below.table.shape[-1]), 2, axis=-1)
    if below.lobe is not None:
        own = lobes.f(below.lobe, wi[..., None, :], wo[..., None, :])
        if below.depth.any():
            own = own * np.exp(-below.depth * (1 / wi[..., 2, None] + 1 / wo[..., 2, None]))
        direct = direct + own
    return direct * below.times(wi[..., 2]) * below.times(wo[..., 2]) + more


def _turned(w: Vector, turn: np.ndarray) -> Vector:
    """Directions turned about the normal by angles (N, 1)."""
    cos, sin = np.cos(turn), np.sin(turn)
    return cos * w[0] - sin * w[1], sin * w[0] + cos * w[1], w[2]
