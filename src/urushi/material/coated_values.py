"""f of coated materials at pairs of directions, by light transport through the coat.

f of the coated material, without the lobe of its interface, is

    1 / eta^2 E[w_i w_o S(wi', wo')],

where wi' and wo' are wi and wo after refraction at random facets of the interface, w_i and w_o the
transmitted fractions (`urushi.material.crossing`), and S is the BRDF of everything below, seen from
just below the interface: the bottom through the medium, and all light that the medium scatters or
that the interface reflects back (`urushi.material.adding`). Light that smooth surfaces mirror back
and forth stays in the narrow lobe of the bottom. An index of 1 is no interface, and f is S itself.

The mean is a sum over fixed pairs wi', wo'. Facets of width alpha tilt half vectors inside by about
|1 - 1 / eta| alpha. Where that is not far below the width of the bottom's lobe, few pairs hit the
lobe. Directions are then drawn from one of wi', wo' and a half vector of the lobe too, and the
balance heuristic combines all (Veach and Guibas 1995). It counts half vectors by a small share:
next to wide lobes, their weights are noisier than the pairs.

A pair costs 5 us over wide lobes and 20 us over narrow ones.
"""

import operator
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters, Widths
from urushi.core import lanes, microfacet
from urushi.core.lanes import Lane
from urushi.core.microfacet import pair
from urushi.core.namespace import DRJIT
from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.core.spanning import spanning
from urushi.core.table import SHAPE, known_pairs
from urushi.material import adding, adding_quadrant
from urushi.material.crossing import GENERATORS, LEAST_COSINE, cross, crossing_at, kept
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate, of_material, parts_of
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import both_ways
from urushi.parallel import run_all_cores

#: Pairs of refracted directions over wide lobes, over narrow ones, and half vectors for each side.
WIDE, NARROW, HALF = 256, 512, 256

#: Tilt of half vectors by an interface, over the width of a lobe, above which the lobe is narrow.
LEAST_TILT = 0.04

#: Share by which the balance heuristic counts half vectors.
HALF_SHARE = 0.2

#: A channel is computed as a sum of others if the root mean square of its relative deviation from
#: the sum is below this, which is about the rounding of a table in half precision.
SPANNED = 2e-3

#: Number of jobs, of one GGX width and of two, that are computed at once; it limits the memory.
JOBS = {1: 64, 2: 8}


def coated_f(
    bottom: Material | Substrate, coat: CoatParameters, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """f float32 (N, ..., C) [1/sr] of coated materials, without the lobes of their interfaces.

    Args:
        bottom: of C channels, or of one; a material without its rotation.
        coat: numbers or arrays (..., C) of coats; bottoms of one width have coats of one.
        wi, wo: float32 (N, 3), above the horizon.
    """
    below = bottom if isinstance(bottom, Substrate) else of_material(bottom)
    widths = pair(coat.alpha)[: below.widths]
    *columns, channels = np.broadcast_arrays(*widths, *coat[1:], np.arange(below.channels))
    flat, count = np.stack([x.ravel() for x in columns]).astype(np.float64), below.widths + 1
    f = coated_values(below, channels.ravel(), flat[:count], flat[count:], wi, wo)
    return f.reshape(len(wi), *channels.shape)


def coated_g(
    bottom: Material | Substrate, coat: CoatParameters, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """g (N, ..., C) [1/sr] of `nets.transmittance`; the arguments are those of `coated_f`."""
    return coated_f(bottom, coat, wi, wo) / passed_twice(coat, wi, wo)


def passed_twice(coat: CoatParameters, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """T(wi) T(wo) (N, ..., C), of `nets.transmittance`, for the interfaces of coats (..., C).

    Coats that are numbers give (N, 1).
    """
    lobe = np.atleast_2d(lobes.of_coat(coat.alpha, coat.eta))
    return both_ways(lobe, *(w.reshape(-1, *[1] * (lobe.ndim - 1), 3) for w in (wi, wo)))


def coated_values(
    below: Substrate,
    channels: np.ndarray,
    interfaces: np.ndarray,
    media: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    points: tuple[int, int, int] = (WIDE, NARROW, HALF),
) -> np.ndarray:
    """f float32 (N, D) [1/sr] of channels (D,) of a substrate under coats.

    Args:
        interfaces: (2, D), widths and relative indices; of two widths (3, D).
        media: (3 k, D), albedo, sigma_t and g of k media, top to bottom; of two widths k is 1.
        points: numbers of `WIDE`, `NARROW` and `HALF`.
    """
    first, which = _distinct(below, channels, np.concatenate([interfaces, media]))
    result, size = np.empty((len(wi), len(first)), np.float32), JOBS[below.widths]
    for start in range(0, len(first), size):
        some = first[start : start + size]
        jobs = _jobs(below, channels[some], interfaces[:, some], media[:, some])
        chosen, weights = _spanning(jobs)
        result[:, start : start + size] = _f(jobs.taken(chosen), (wi, wo), points) @ weights
    return result[:, which]


def _distinct(
    below: Substrate, channels: np.ndarray, coats: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Indices (E,) of channels (D,) under coats (P, D) that differ, and the place (D,) of each
    channel among them. A grey material is computed once."""
    one = below.channels == 1
    names = {k: b"" if one else below.reflector.taken([k]).contents() for k in set(channels)}
    keys = [(names[k], coat.tobytes()) for k, coat in zip(channels, coats.T, strict=True)]
    # Equal coats one after the other: what they share is computed once.
    ordered = sorted(dict.fromkeys(keys), key=operator.itemgetter(1))
    places = {key: place for place, key in enumerate(ordered)}
    which = np.array([places[key] for key in keys])
    return np.unique(which, return_index=True)[1], which


class Jobs(NamedTuple):
    """D interfaces, and the BRDFs below them."""

    bottom: Reflector
    interface: np.ndarray  # (D, 2) of width and relative index, or (D, 3)
    width: np.ndarray  # (D, 1), or (D, 2), of half vectors that are drawn; 0: none
    more: np.ndarray  # float32 (D, ...), of light that medium or interface turn back
    media: np.ndarray  # (D, 3 k), resolved, which attenuate light from the bottom and scatter
    interreflection: np.ndarray | None  # (D, M) a factor of it at `adding.MIRROR_COSINES`

    @property
    def eta(self) -> np.ndarray:
        """The relative indices (D,)."""
        return self.interface[:, -1]

    def taken(self, chosen: Sequence[int] | np.ndarray) -> "Jobs":
        """Some of the jobs."""
        if np.array_equal(chosen, np.arange(len(self.eta))):
            return self  # without a copy of large tables
        parts = (None if x is None else x[np.asarray(chosen)] for x in self[1:])
        return Jobs._make([self.bottom.taken(chosen), *parts])


def _jobs(
    below: Substrate, channels: np.ndarray, interfaces: np.ndarray, media: np.ndarray
) -> Jobs:
    """The jobs of channels (D,), see `coated_values`."""
    *widths, eta = interfaces
    layers = media.T.reshape(len(channels), -1, 3)
    layers = np.array([[adding.resolved(*layer) for layer in own] for own in layers])
    if below.widths == 2:
        bottoms = [parts_of(below, c) for c in channels]
        more, factors = np.empty((len(channels), *adding_quadrant.TABLE), np.float32), None

        def fill(job: int) -> None:
            *alpha, index = interfaces[:, job]
            back = adding_quadrant.interface_parts(Widths(*alpha), index)
            light = adding_quadrant.seen_inside(bottoms[job], back, layers[job, 0].tolist())
            more[job] = adding_quadrant.table(light)

        run_all_cores(fill, range(len(channels)))
    else:
        more, factors = _turned_back(below, channels, interfaces, layers)
    width, tilt = below.width[channels], np.abs(1 - 1 / eta) * np.max(widths, axis=0)
    narrow = tilt > LEAST_TILT * width.min(axis=1)
    return Jobs(
        below.reflector.taken(channels),
        interfaces.T,
        np.where(narrow[:, None], width, 0),
        more,
        layers.reshape(len(layers), -1),
        factors,
    )


def _turned_back(
    below: Substrate, channels: np.ndarray, interfaces: np.ndarray, media: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Light of one width that media (D, k, 3) or interfaces turn back, see `Jobs`.

    Returns:
        float32 (D, U, V, W), ln f at the nodes of the table; and the factors.
    """
    more = np.empty((len(channels), *SHAPE), np.float32)
    factors = np.ones((len(channels), len(adding.MIRROR_COSINES)), np.float32)
    edges = [below.edges(eta) for eta in interfaces[1]]
    for own in set(edges):
        members = np.array([at == own for at in edges]).nonzero()[0]
        which, places = np.unique(channels[members], return_inverse=True)
        _, modes, mirrored = below.on_grid(which, own)
        for job, place in zip(members, places, strict=True):
            alpha, eta = interfaces[:, job]
            back = adding.interface_modes(alpha, eta, own)
            values, depth = adding.seen_inside(modes[place], back, media[job], own)
            values = adding.at_nodes(values, own, below.reflector.knots)
            more[job] = np.log(np.maximum(values, 1e-30))
            lower = mirrored[:, [place]]
            if lower.any():
                upper = adding.mirror(alpha, eta, own)
                factors[job] = adding.interreflection([depth], upper, lower)[1][:, 0]
    return more, factors if (factors != 1).any() else None


def _spanning(jobs: Jobs) -> tuple[list[int], np.ndarray]:
    """Indices of jobs (E,), and weights (E, D) by which sums of their f are those of all jobs.

    f of the coated material is linear in the BRDF below, so that fewer channels suffice for the
    bands of a spectrum, up to `SPANNED`. The next channel is always the farthest from sums of the
    chosen ones.
    """
    chosen, weights = list[int](), np.zeros((len(jobs.eta), len(jobs.eta)), np.float32)
    _, groups = np.unique(jobs.interface, axis=0, return_inverse=True)
    for group in range(groups.max() + 1):
        members = np.flatnonzero(groups.ravel() == group)
        if len(members) <= 3:
            own, shares = list(range(len(members))), np.eye(len(members), dtype=np.float32)
        else:
            own, shares = _basis(_seen(jobs.taken(members)))
        rows = len(chosen) + np.arange(len(own))
        weights[np.ix_(rows, members)] = shares
        chosen += members[own].tolist()
    return chosen, weights[: len(chosen)]


def _basis(s: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Columns (E,) of values (P, D), and weights (E, D), see `_spanning`."""
    relative = s / np.maximum(s.mean(axis=1, keepdims=True), 1e-30)  # some pairs see nothing
    sizes = np.linalg.norm(relative, axis=0)
    if not sizes.any():  # all are black
        return [0], np.ones((1, s.shape[1]))
    relative /= np.where(sizes > 0, sizes, 1)
    chosen, along = spanning(relative.T, SPANNED, s.shape[1])
    # Least squares by the axes that were found, of which each chosen column is a sum
    weights = np.linalg.solve(along[:, chosen], along)
    return chosen, weights * (sizes / sizes[chosen, None])


def _seen(jobs: Jobs) -> np.ndarray:
    """The BRDFs below (P, D) at some nodes of the table, of two widths at the probe pairs."""
    if jobs.bottom.stretch2 is None:
        pairs = known_pairs(jobs.bottom.knots)
    else:
        pairs = list(probe_pairs(ANISOTROPIC_PROBES, 2))
    matched = np.concatenate([jobs.interface[:, :-1], np.ones((len(jobs.eta), 1))], axis=1)
    return _f(jobs._replace(interface=matched), pairs, (1, 1, 1))


def _f(jobs: Jobs, pairs: Sequence[np.ndarray], points: tuple[int, int, int]) -> np.ndarray:
    """f (N, D) of jobs, without the interfaces' lobes (see the module)."""
    result = np.empty((len(pairs[0]), len(jobs.eta)), np.float32)
    wide, narrow, half = points
    drawn = jobs.width[:, 0] > 0
    matched = jobs.eta == 1
    for chosen, count, own in (
        (matched, 1, 0),
        (~matched & ~drawn, wide, wide),
        (~matched & drawn, half, narrow),
    ):
        if chosen.any():
            some = jobs.taken(np.flatnonzero(chosen))
            kernel = _Kernel(some, own, half if own and drawn[chosen].all() else 0)
            result[:, chosen] = lanes.sums(kernel, int(chosen.sum()), pairs, count)
    return result


class _Kernel:
    """Summands of f at the points of pairs, for `lanes.sums`."""

    def __init__(self, jobs: Jobs, refracted: int, half: int) -> None:
        """refracted, half: numbers of points of each pair, 0 without an interface and for none."""
        self._jobs, self._refracted, self._half = jobs, refracted, half

    def __call__(self, lane: Lane) -> Any:
        jobs, (wi, wo) = self._jobs, lane.directions()
        self._bottom, self._more = jobs.bottom.in_lane(lane), lane.table(jobs.more)
        self._interreflection = (
            None if jobs.interreflection is None else lane.nearest(jobs.interreflection)
        )
        numbers = iter([lane.number(x) for x in jobs.media.T] if jobs.media.any() else [])
        self._media = list(zip(numbers, numbers, numbers, strict=True))
        if not self._refracted:
            once, places = self._once(wi, wo)
            return once + self._again(wi, wo, places)
        *widths, eta = (lane.number(x) for x in jobs.interface.T)
        alpha = widths[0] if len(widths) == 1 else Widths(*widths)
        if self._half:
            drawn = [lane.number(x) for x in jobs.width.T]
            self._width: Any = drawn[0] if len(drawn) == 1 else Widths(*drawn)
        total: Any = 0.0
        step = self._half or self._refracted
        for first in range(0, self._refracted, step):
            u = lane.lattice(self._refracted, GENERATORS[self._refracted], first)
            a, b = cross(wi, alpha, eta, u[:2], DRJIT), cross(wo, alpha, eta, u[2:], DRJIT)
            once, places = self._once(a.inside, b.inside)
            again = self._again(a.inside, b.inside, places) * (a.weight * b.weight)
            total = total + (once * self._weight(a, b) + again) / self._refracted
        if self._half:
            u = lane.lattice(self._half, GENERATORS[self._half])
            for near, far, own, others in ((wi, wo, u[:2], u[2:]), (wo, wi, u[2:], u[:2])):
                a = cross(near, alpha, eta, own, DRJIT)
                once = self._by_half_vectors(a, far, alpha, eta, others)
                total = total + once * (HALF_SHARE / self._half)
        return total / (eta * eta)

    def _once(self, wi: Any, wo: Any) -> tuple[Any, tuple[Any, ...]]:
        """Light that the bottom reflects, and the coordinates of the pair in the tables."""
        value, places = self._bottom(wi, wo)
        value = value * self._by_media(wi, wo)[1]
        if self._interreflection is not None:
            value = value * (self._interreflection(wi.z) * self._interreflection(wo.z))
        return value, places

    def _again(self, wi: Any, wo: Any, places: tuple[Any, ...]) -> Any:
        """Light that the media or the interface turn back."""
        once, _ = self._by_media(wi, wo)
        if self._jobs.bottom.stretch2 is None:
            return once + DRJIT.exp(self._more(places))
        return once + self._more(adding_quadrant.coordinates(wi, wo, DRJIT))

    def _by_media(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """Light that the media reflect once, and the share that they leave of other light."""
        cosine = wi.x * wo.x + wi.y * wo.y + wi.z * wo.z
        return adding.reflected_once(self._media, wi.z, wo.z, cosine, DRJIT)

    def _weight(self, a: Any, b: Any) -> Any:
        """The weight of a pair of crossings by the balance heuristic."""
        weight = a.weight * b.weight
        if not self._half:
            return weight
        h, square = a.inside + b.inside, microfacet.product(self._width)
        size2, z2 = h.x * h.x + h.y * h.y + h.z * h.z, h.z * h.z
        # GGX's D cos theta_h. Reflection about h stretches solid angles by 4 cos theta_d.
        spread = microfacet.squeezed_sine2(h, self._width) + square * z2
        drawn = square * h.z * size2 / (2 * np.pi * (spread * spread))
        others = 1 / DRJIT.maximum(a.density, 1e-30) + 1 / DRJIT.maximum(b.density, 1e-30)
        return weight / (1 + HALF_SHARE * drawn * others)

    def _by_half_vectors(self, near: Any, far: Any, alpha: Any, eta: Any, u: Any) -> Any:
        """Light that a half vector, drawn with numbers u by GGX's D cos theta_h, sends to `far`."""
        w, (along, across) = near.inside, pair(self._width)
        tangent, (sin_phi, cos_phi) = DRJIT.sqrt(u[0] / (1 - u[0])), DRJIT.sincos(2 * np.pi * u[1])
        half = type(w)(along * tangent * cos_phi, across * tangent * sin_phi, 1)
        half = DRJIT.normalized(half)
        cosine = w.x * half.x + w.y * half.y + w.z * half.z
        seen = 2 * cosine * half - w
        reached = (near.weight > 0) & (cosine > 0) & (seen.z > LEAST_COSINE)
        seen = kept(seen, reached, DRJIT)
        other = crossing_at(far, seen, alpha, eta, DRJIT)
        return DRJIT.where(reached, self._once(w, seen)[0] * self._weight(near, other), 0)
