"""Layers of slabs, and the shares of light that they reflect and transmit.

A table of f holds a narrow lobe by a few of its nodes, so that its integrals are off by some per
cent. Shares of light depend on the elevation alone, for which adding (van de Hulst 1980) has a fine
grid: light that arrives between two of its nodes is shared among them, and none is lost. With the
shares R and T of everything below an interface as matrices, and r and t those of the interface for
light from above and r' and t' from below, the shares of both are

    r + t (1 - R r')^-1 R t',    t (1 - R r')^-1 T.
"""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_INDEX_STEP
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.material import adding
from urushi.material.crossing import cross, facet_points, in_plane, mirrored

#: Elevations of the grids, and facets that light of each of them meets.
ELEVATIONS, FACETS = 64, 256

#: The grid with some edges.
_grid = functools.partial(adding.grid, elevations=ELEVATIONS, orders=1)


class Layers(NamedTuple):
    """A slab of C channels, without interfaces of index 1: they only join the media beside them."""

    # (n + 1, 2) alpha and eta, top to bottom, each relative to the medium above. Only the first and
    # the last one may have the index 1, next to a medium.
    interfaces: np.ndarray
    # n arrays (k, 3, C) of albedo, sigma_t and g between the interfaces; of clear ones k is 0
    media: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, interfaces: np.ndarray, media: np.ndarray) -> "Layers":
        """The layers of (n + 1, 2) interfaces and the media (n, 3, C) between them."""
        kept, gaps = [interfaces[0]], list[list[np.ndarray]]()
        for interface, medium in zip(interfaces[1:], media, strict=True):
            if abs(kept[-1][1] - 1) >= MIN_INDEX_STEP or not gaps:
                gaps.append([])
            else:
                kept.pop()
            gaps[-1] += [medium] if medium[1].any() else []
            kept.append(interface)
        matched = [abs(eta - 1) < MIN_INDEX_STEP for _, eta in kept]
        first, last = (matched[i] and not gaps[i] for i in (0, -1))
        chosen = slice(int(first), len(kept) - int(last))
        result = np.where(np.array(matched)[:, None], (1.0, 1.0), kept)[chosen]
        shape = -1, *media.shape[1:]
        gaps = gaps[int(first) : len(gaps) - int(last)]
        return cls(result, tuple(np.reshape(gap, shape) for gap in gaps))

    def turned(self) -> "Layers":
        """The slab upside down."""
        interfaces = np.stack([self.interfaces[:, 0], 1 / self.interfaces[:, 1]], axis=1)
        return Layers(interfaces[::-1], tuple(media[::-1] for media in self.media[::-1]))

    def indices(self) -> np.ndarray:
        """(n + 2,) indices of the media relative to that above all."""
        return np.append(1, self.interfaces[:, 1].cumprod())

    def edges(self, level: int) -> adding.Edges:
        """Angles of total reflection in the media above an interface: of every other index."""
        indices = self.indices()
        sines = indices / indices[level]
        return tuple(np.unique(np.arcsin(sines[sines < 1 - 1e-6]).round(4)).tolist())

    def face(self) -> tuple[float, float]:
        """Alpha and eta of the first interface of an index other than 1."""
        alpha, eta = self.interfaces[int(self.interfaces[0, 1] == 1)]
        return float(alpha), float(eta)

    def inner_lobes(self) -> list[tuple[float, float, float]]:
        """Index above, width and eta of each interface below the first one of `face`.

        Facets above tilt light that goes through, and widen the lobe (small slopes).
        """
        indices, found, spread = self.indices(), [], 0.0
        first = int(self.interfaces[0, 1] == 1)
        for level, (alpha, eta) in enumerate(self.interfaces):
            if level > first and eta != 1:
                width = (alpha**2 + 0.5 * spread / indices[level] ** 2) ** 0.5
                found.append((float(indices[level]), float(min(width, 1)), float(eta)))
            spread += ((indices[level + 1] - indices[level]) * alpha) ** 2
        return found

    def depth(self, channels: int) -> np.ndarray:
        """(C,) optical depth of the media above it."""
        result = np.zeros(channels)
        for medium in self.media[0] if self.interfaces[0, 1] == 1 else ():
            result += [adding.resolved(*column)[1] for column in medium.T]
        return result


class Shares(NamedTuple):
    """Shares (N, C) of the light of directions at angles (N,)."""

    edges: adding.Edges
    angles: np.ndarray
    reflected: np.ndarray  # without the lobe of the first interface, through the media above it
    passed: np.ndarray  # transmitted


def shares(layers: Layers, channels: int) -> list[Shares]:
    """Shares of the slab, and of what lies below its second interface, its third, and so on."""
    edges = [layers.edges(level) for level in range(len(layers.interfaces) + 1)]
    found: list[list[tuple]] = [[] for _ in layers.interfaces]
    for channel in range(channels):
        size = len(_grid(edges[-1]).angles)
        lobe, below, passed = np.zeros((size, size)), np.zeros((size, size)), np.ones(size)
        for level in reversed(range(len(layers.interfaces))):
            if level < len(layers.media):
                for layer in layers.media[level][::-1, :, channel].tolist():
                    both = _medium(layer, edges[level + 1])
                    below, passed = _over(both, both, below, passed)
                    left = np.exp(-adding.resolved(*layer)[1] / _grid(edges[level + 1]).cosines)
                    lobe = left[:, None] * lobe * left
            alpha, eta = layers.interfaces[level]
            if eta != 1:
                near, far = edges[level : level + 2]
                above = _interface(alpha, eta, near, far)
                below, passed = _over(above, _interface(alpha, 1 / eta, far, near), below, passed)
                lobe = above[0]
            found[level].append(((below - lobe).sum(axis=1), passed))
    return [
        Shares(own, _grid(own).angles, *(np.stack(x, axis=-1) for x in zip(*columns, strict=True)))
        for own, columns in zip(edges[:-1], found, strict=True)
    ]


def _over(
    above: tuple[np.ndarray, np.ndarray],
    back: tuple[np.ndarray, np.ndarray],
    below: np.ndarray,
    passed: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Shares of a layer over others, of light that is reflected (N, N) and transmitted (N,).

    above, back: what the layer reflects and transmits of light from above, and from below.
    """
    between = np.eye(len(below)) - below @ back[0]
    down = np.linalg.solve(between.T, above[1].T).T
    return above[0] + down @ below @ back[1], down @ passed


@functools.lru_cache(maxsize=32)
def _interface(
    alpha: float, eta: float, near: adding.Edges, far: adding.Edges
) -> tuple[np.ndarray, np.ndarray]:
    """Shares (N, N) of light that an interface reflects, and (N, M) that crosses it.

    eta: far over near. near, far: edges of the grids on both sides.
    """
    grids = [_grid(edges) for edges in (near, far)]
    outside, u = in_plane(grids[0].cosines.astype(np.float32)[:, None]), facet_points(FACETS)
    crossing, turned = cross(outside, alpha, eta, u), mirrored(outside, alpha, u)
    weight = turned.masking * fresnel.dielectric(turned.cosine, np.float32(eta), NUMPY)[0]
    reflected = grids[0].received(turned.outwards, weight / FACETS)[0]
    return reflected, grids[1].received(crossing.inside, crossing.weight / FACETS)[0]


def _medium(layer: Sequence[float], edges: adding.Edges) -> tuple[np.ndarray, np.ndarray]:
    """Shares (N, N) of light that a medium reflects and transmits."""
    own = _grid(edges)
    albedo, sigma_t, g = adding.resolved(*layer)
    through = np.diag(np.exp(-sigma_t / own.cosines))
    if albedo * sigma_t <= adding.LEAST_SCATTERING:
        return np.zeros_like(through), through
    reflected, passed = (x[0] * own.weights for x in adding.medium(albedo, sigma_t, g, own))
    return reflected, through + passed
