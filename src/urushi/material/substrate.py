"""A BRDF below coats: all that light transport through any coat needs of it, computed once."""

import functools
from typing import NamedTuple

import numpy as np

from urushi.core import microfacet
from urushi.core.namespace import NUMPY, Components
from urushi.core.quadrature import half_vector_rule
from urushi.core.table import (
    HIGHEST,
    LOWEST,
    SHAPE,
    TAN2_OFFSET,
    Knots,
    corners,
    node_pairs,
    pair_coordinates,
)
from urushi.material import adding
from urushi.material.material import Material
from urushi.nets import lobe as lobes

#: A lobe's width is where it has this part of its peak, as GGX has at tan theta_h = alpha.
PART_OF_PEAK = 0.25

#: Tilt of half vectors by an interface, over the width of a lobe, above which the lobe is narrow.
LEAST_TILT = 0.04

#: Azimuths, in each half of the range, of the quadrature of the albedo.
AROUND = 8


class Substrate(NamedTuple):
    """A BRDF of C channels below coats: all that coats need of it. Make it with `of`."""

    logs: np.ndarray  # float32 (U, V, W, C), ln f beside the lobes
    lobe: np.ndarray | None  # float32 (C, N), see `nets.lobe`
    modes: np.ndarray  # (C, H, N, N), see `adding`
    mirrored: np.ndarray  # (M, C) shares of light at `adding.COSINES` that it mirrors
    width: np.ndarray  # (C,) of its brightest lobe; infinite without one
    edges: adding.Edges = ()  # of the medium above it
    knots: Knots = ()  # of the table

    @classmethod
    def of(
        cls, bottom: Material, modes: np.ndarray | None = None, edges: adding.Edges = ()
    ) -> "Substrate":
        """A material as a substrate; in slabs with its modes, in a medium with these edges."""
        beside = bottom.table is None or bottom.beside_lobe
        lobe = bottom.latents[:, : bottom.model.arch.lobe] if beside else None
        return cls.of_logs(bottom.logs(), lobe, modes, edges, bottom.knots)

    @classmethod
    def of_logs(
        cls,
        logs: np.ndarray,
        lobe: np.ndarray | None = None,
        modes: np.ndarray | None = None,
        edges: adding.Edges = (),
        knots: Knots = (),
    ) -> "Substrate":
        """The substrate of ln f (U, V, W, C) at the table's nodes, beside lobes (C, N)."""
        logs, own = logs.astype(np.float32), adding.grid(edges)
        if modes is None:
            lookup = _grid_lookup()
            values = lookup.f(logs, lobe).astype(np.float64)
            count = len(values) - lookup.weights.size
            light = values[count:].reshape(*lookup.weights.shape, -1)
            albedo = np.einsum("nmc,nm->nc", light, lookup.weights)
            modes = adding.modes_of_values(values[:count], albedo, edges)
        mirrored = own.at_cosines(np.stack([own.mirror_shares(m) for m in modes], axis=-1))
        return cls(logs, lobe, modes, mirrored, _widths(logs, lobe, knots), edges, knots)

    @property
    def channels(self) -> int:
        """The number of channels, C."""
        return self.logs.shape[-1]

    def narrow(self, alpha: np.ndarray, eta: np.ndarray, channels: np.ndarray) -> np.ndarray:
        """Whether the lobes of channels (D,) are narrow below interfaces (D,)."""
        return np.abs(1 - 1 / eta) * alpha > LEAST_TILT * self.width[channels]


class _Lookup(NamedTuple):
    """Pairs at which a substrate is evaluated for its modes."""

    wi: Components  # float32 (M,) each
    wo: Components
    corners: list[tuple[np.ndarray, np.ndarray]]  # nodes and shares (M,)
    weights: np.ndarray  # (N, Q) of the last N Q pairs, with cosines: they integrate an albedo

    def f(self, logs: np.ndarray, lobe: np.ndarray | None) -> np.ndarray:
        """f (M, C) of tables and lobes as of `Substrate`."""
        rows = logs.reshape(-1, logs.shape[-1])
        values = np.zeros((len(self.wi.x), rows.shape[1]), np.float32)
        for nodes, share in self.corners:
            values += rows.take(nodes, axis=0) * share[:, None]
        values = np.exp(values)
        return values if lobe is None else values + lobes_f(lobe, self.wi, self.wo)


@functools.cache
def _grid_lookup() -> _Lookup:
    own = adding.grid()
    incident = np.stack([np.sin(own.angles), 0 * own.angles, own.cosines], axis=-1)
    outgoing, weights = half_vector_rule(incident, azimuths=AROUND)
    weights = weights * outgoing[..., 2]
    first = np.repeat(incident, weights.shape[1], axis=0), outgoing.reshape(-1, 3)
    pairs = zip(own.pairs(), first, strict=True)
    wi, wo = (np.concatenate(sides).astype(np.float32) for sides in pairs)
    at = [(i, s.astype(np.float32)) for i, s in corners(SHAPE, *pair_coordinates(wi, wo))]
    return _Lookup(Components(*wi.T.copy()), Components(*wo.T.copy()), at, weights)


def lobes_f(lobe: np.ndarray, wi: Components, wo: Components) -> np.ndarray:
    """f (M, C) of lobes (C, N), as `lobes.f`, at pairs (M,) above the horizon."""
    h = microfacet.half_vector(wi, wo, NUMPY)
    cosine, result = microfacet.facet_cosine(h, NUMPY), np.empty((len(h.x), len(lobe)), np.float32)
    shapes = {a: microfacet.lobe_shape(a, wi, wo, h, NUMPY) for a in set(lobe[:, 0])}
    for channel, (alpha, normal, grazing, exact, eta, k) in enumerate(lobe):
        numbers = [
            *((normal, grazing) if normal or grazing else (None, None)),
            *((exact, eta, k if k else None) if exact else (None, None, None)),
        ]
        result[:, channel] = shapes[alpha] * lobes.reflectance_of(numbers, cosine, NUMPY)
    return result


def _widths(logs: np.ndarray, lobe: np.ndarray | None, knots: Knots) -> np.ndarray:
    """The widths (C,) of the brightest lobes of a table and lobes."""
    some = np.ix_(np.arange(SHAPE[0]), np.arange(0, SHAPE[1] // 2, 4), np.arange(0, SHAPE[2], 3))
    values = np.exp(logs[some]).reshape(-1, logs.shape[-1])
    if lobe is not None:
        pairs = (w.reshape(*SHAPE, 3)[some].reshape(-1, 3) for w in node_pairs(knots))
        values = values + lobes_f(lobe, *(Components(*w.T) for w in pairs))
    profiles = np.log(values.reshape(SHAPE[0], -1, logs.shape[-1]).mean(axis=1))
    result = []
    for profile in profiles.T:
        peak = int(profile.argmax())
        level = profile[peak] + np.log(PART_OF_PEAK)
        lower = peak + np.flatnonzero(profile[peak:] < level)
        if not len(lower):
            result.append(np.inf)
            continue
        last = lower[0]
        part = (profile[last - 1] - level) / (profile[last - 1] - profile[last])
        u = (last - 1 + part) / (SHAPE[0] - 1)
        tan2 = np.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET
        result.append(np.sqrt(max(tan2, TAN2_OFFSET)))
    return np.array(result)
