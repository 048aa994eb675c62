"""Light transport inside a coat by adding and doubling on a grid of directions.

A BRDF below a coat's interface is one matrix per Fourier mode of the azimuth between directions
(Hansen 1971; Stam 2001). With K the BRDF, W the cosines times the weights of the quadrature, and J
the reflection of the interface from below, light that is reflected any number of times is

    (1 - K W J W)^-1 K,

and a medium above the BRDF, of reflection P and transmission E + T (unscattered and scattered), is

    P + (E + T W) (1 - K W P W)^-1 K (E + W T).

All directions point away from the reflecting layer, so that a mirror rotates the azimuth by half a
turn, in modes (-1)^m. BRDFs may be narrower than the grid: the part of their albedo that it misses
is added as a mirror reflection.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.core import fresnel, microfacet
from urushi.core.namespace import NUMPY, Components, Namespace
from urushi.core.quadrature import POLAR_NODES, directional_albedos, gauss
from urushi.core.table import SHAPE, Knots, corners, interpolated_columns, node_pairs
from urushi.material.crossing import in_plane, inner_albedo
from urushi.material.energy import TOLERANCE
from urushi.walk.medium import hg

#: Directions of the grid in elevation, and around.
ELEVATIONS, AZIMUTHS = 24, 48

#: Elevations for each of the grid by which means about them are taken, of one number and of modes.
FINE, FINE_MODES = 10, 4

#: Azimuths of a lobe for each of the grid.
DENSE = 8

#: How much denser nodes are at angles of total reflection: spacing is 1 - `DENSITY` times as wide.
DENSITY = 0.8

#: Largest asymmetry of a phase function on the grid. A sharper forward peak counts as unscattered.
LARGEST_ASYMMETRY = 0.9

#: Albedo, with its error, up to which a bottom gains no energy; cosines at which this is measured;
#: and the largest factor of light between a bottom that gains some and what is above it.
CONSERVING, GAINING, LARGEST_GAIN = 1 + TOLERANCE, np.array([0.95, 0.6, 0.3]), 0.998

#: Least asymmetry that the grid resolves; a sharper backward peak counts as this one.
RESOLVED_G = -0.95

#: Optical depth at which doubling begins, and the least depth of scattering that counts.
FIRST_DEPTH, LEAST_SCATTERING = 1e-4, 1e-6

#: Least mode of a phase function, of the first one, that counts.
LEAST_MODE = 1e-6

#: Rounds of the scalings that give rows their sums.
ROUNDS = 20

#: Ascending angles inside a medium at which light begins to be totally reflected.
Edges = tuple[float, ...]

#: Cosines at which the interreflection of mirrors is tabulated.
MIRROR_COSINES = np.linspace(1 / (1 << 12), 1, 1 << 12).astype(np.float32)

#: BRDF values (N, C) of float32 unit vectors (N, 3).
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Grid:
    """Directions on the hemisphere: Gauss-Legendre nodes in the angle, evenly spaced azimuths.

    Each part of the angles between `edges`, where light is totally reflected, has its own nodes.
    """

    def __init__(
        self, edges: Edges = (), elevations: int = ELEVATIONS, orders: int = AZIMUTHS // 2 + 1
    ):
        """orders: number of modes that are kept; all by default."""
        parts, self._edges, self.orders = [], edges, orders
        for start, end in itertools.pairwise((0.0, *edges, 0.5 * np.pi)):
            size = end - start
            nodes, weights = gauss(max(round(elevations * size / (0.5 * np.pi)), 4))
            t = 0.5 * (nodes + 1)  # the place of a node in its part, before it is moved to edges
            low, high = int(start > 0), int(end < 0.5 * np.pi)
            bend = DENSITY * (high - low + (low & high) * (2 * t - 1))
            moved = t + bend * t * (1 - t)
            slope = 1 + bend * (1 - 2 * t) + 2 * DENSITY * (low & high) * t * (1 - t)
            parts.append((start + size * moved, 0.5 * size * weights * slope))
        self.angles, weights = np.concatenate(parts, axis=1)  # (N,) ascending, to the normal
        self.cosines = np.cos(self.angles)
        # (N,) They integrate over the cosine times the cosine.
        self.weights = weights * np.sin(self.angles) * self.cosines
        self.azimuths = np.linspace(0, np.pi, AZIMUTHS // 2 + 1)  # (H,)
        self.mirror = (-1.0) ** np.arange(len(self.azimuths))  # the modes of a mirror reflection
        self._upper = np.triu_indices(len(self.angles))

    def dots(self) -> np.ndarray:
        """Cosines (N, N, H) between directions."""
        along, across = (np.outer(x, x)[..., None] for x in (self.cosines, np.sin(self.angles)))
        return along + across * np.cos(self.azimuths)

    def pairs(self, dense: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Pairs float32 (M, 3) at which `values` takes a BRDF: half of all, by reciprocity.

        dense: pairs for each azimuth of the grid.
        """
        azimuths = np.linspace(0, np.pi, dense * (len(self.azimuths) - 1) + 1)
        first, second, turn = (
            x.ravel() for x in np.broadcast_arrays(*(i[:, None] for i in self._upper), azimuths)
        )
        sines = np.sin(self.angles)
        wi = np.stack([sines[first], 0 * turn, self.cosines[first]], axis=-1)
        wo = np.stack(
            [sines[second] * np.cos(turn), sines[second] * np.sin(turn), self.cosines[second]],
            axis=-1,
        )
        return wi.astype(np.float32), wo.astype(np.float32)

    def values(self, f: np.ndarray) -> np.ndarray:
        """A BRDF (N, N, K) from its values (M,) at `pairs`, K azimuths from 0 to pi."""
        count = len(self.cosines)
        rows = f.reshape(len(self._upper[0]), -1)
        result = np.empty((count, count, rows.shape[1]))
        result[self._upper], result[self._upper[::-1]] = rows, rows
        return result

    def modes(self, values: np.ndarray) -> np.ndarray:
        """Modes (H, N, N) of values (N, N, K)."""
        around = np.concatenate([values, values[..., -2:0:-1]], axis=-1)
        modes = np.fft.rfft(around, axis=-1).real * (2 * np.pi / around.shape[-1])
        return np.moveaxis(modes, -1, 0)[: self.orders]

    def values_of_modes(self, modes: np.ndarray) -> np.ndarray:
        """Values (N, N, H) of modes (H, N, N)."""
        around = np.fft.irfft(np.moveaxis(modes, 0, -1), n=AZIMUTHS, axis=-1)
        return around[..., : len(self.azimuths)] * (AZIMUTHS / (2 * np.pi))

    def brdf_modes(self, f: np.ndarray, albedo: np.ndarray) -> np.ndarray:
        """Modes (H, N, N) of a BRDF with values f (M,) at `pairs` and albedos (N,).

        The values at mirror pairs, where lobes are narrow, are set so that the sums equal the
        albedos. If the other values already exceed the albedo, they are scaled down.
        """
        values, places = self.values(f), np.arange(len(self.cosines))
        dense = (values.shape[-1] - 1) // (len(self.azimuths) - 1)
        values[places, places, -1 - dense // 2 :] = 0
        modes = self.modes(values)
        factors, missing = albedo_factors(modes[0], self.weights, albedo)
        modes = modes * (factors[:, None] * factors)
        return modes + self.mirror[:, None, None] * np.diag(missing / self.weights)

    def interpolated(self, values: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """Values (M, C) for pairs (M, 3), from values on the grid (N, N, H, C)."""
        rows = values.reshape(-1, values.shape[-1])
        return sum(share[:, None] * rows[index] for index, share in self.corners(wi, wo))

    def corners(self, wi: np.ndarray, wo: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """The nodes (M,) of values on the grid around pairs (M, 3), and their shares float32."""
        cross = wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]
        dot = wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1]
        angles = [np.arccos(np.clip(w[:, 2], -1, 1)) for w in (wi, wo)]
        axes = self.angles, self.angles, self.azimuths
        places = [
            np.interp(x, axis, np.linspace(0, 1, len(axis)))
            for x, axis in zip((*angles, np.abs(np.arctan2(cross, dot))), axes, strict=True)
        ]
        return corners([len(axis) for axis in axes], *places)

    def at_cosines(self, values: np.ndarray) -> np.ndarray:
        """Values (M, C) at `MIRROR_COSINES`, float32, of values (N, C) at the nodes."""
        found = interpolated_columns(MIRROR_COSINES, self.cosines[::-1], values[::-1])
        return found.astype(np.float32)

    def mirror_shares(self, modes: np.ndarray) -> np.ndarray:
        """The part (N,) of the albedo of a BRDF that `brdf_modes` added as a mirror reflection."""
        values = self.values_of_modes(modes)
        places = np.arange(len(self.cosines))
        return values[places, places, -1] * self.weights * (2 * np.pi / AZIMUTHS)

    def shares(self, angles: np.ndarray) -> np.ndarray:
        """Shares (..., N) of the nodes in values at angles (...), as by linear interpolation."""
        nodes = np.arange(len(self.angles), dtype=np.float32)
        place = np.interp(angles, self.angles, nodes).astype(np.float32)
        shares = 1 - np.abs(place[..., None] - nodes)
        return np.maximum(shares, 0, out=shares)

    def received(self, w: Sequence[np.ndarray], weights: np.ndarray) -> np.ndarray:
        """Modes (H, M, N) of the light that the nodes get, each its `shares` of weights (M, K).

        w: components (M, K) of directions, of light that comes from the azimuth 0.
        """
        x, y, z = w
        shares, turn = self.shares(np.arccos(np.clip(z, 0, 1))), np.arctan2(y, x)
        orders = np.arange(self.orders, dtype=turn.dtype)[:, None]
        waves = weights[:, None] * np.cos(orders * turn[:, None])
        return np.moveaxis(waves @ shares, 1, 0)

    def averaged(self, function: Callable[["Grid"], np.ndarray], finer: int) -> np.ndarray:
        """Means (..., N) about each node of a function of direction, as by linear interpolation.

        The values at the nodes alone would miss the edge of total reflection.

        function: its values (L,), or (..., L, M), at the L nodes of a finer grid.
        """
        fine = Grid(self._edges, finer * len(self.angles))
        shares = self.shares(fine.angles) * fine.weights[:, None]
        return (shares / shares.sum(axis=0)).T @ function(fine)


#: Grids by their arguments: those of coats by their edges alone.
grid = functools.lru_cache(maxsize=128)(Grid)


def at_nodes(values: np.ndarray, edges: Edges, knots: Knots) -> np.ndarray:
    """Values float32 (U, V, W) at the nodes of `core.table` of values (N, N, H) on the grid."""
    rows, total = values.ravel().astype(np.float32), np.zeros(math.prod(SHAPE), np.float32)
    for index, share in _node_corners(edges, knots):
        total += rows.take(index) * share
    return total.reshape(SHAPE)


@functools.lru_cache(maxsize=16)
def _node_corners(edges: Edges, knots: Knots) -> list[tuple[np.ndarray, np.ndarray]]:
    return grid(edges).corners(*node_pairs(knots))


def albedos(f: Brdf, cosines: np.ndarray, polar: int = POLAR_NODES) -> np.ndarray:
    """Directional albedos (N, C) of a BRDF at cosines (N,), by 32 `polar` directions for each."""
    return directional_albedos(f, np.stack(in_plane(cosines), axis=-1), polar=polar)


def ceilings(f: Brdf) -> np.ndarray:
    """The largest albedos (C,) of a BRDF and of coats over it: 1, or more if it gains energy."""
    found = albedos(f, GAINING).max(axis=0)
    return np.where(found > CONSERVING, found, 1)


def albedo_factors(
    even: np.ndarray, weights: np.ndarray, albedo: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Factors (N,) of both directions that keep the albedos of a BRDF below known ones (N,).

    Args:
        even: (N, N) the BRDF's mean over the azimuth, or its even part.
        weights: (N,) of the directions, by which its sums are albedos.

    Returns:
        The factors, and the parts (N,) of the known albedos that are then missing, at most 1.
    """
    factors = np.ones(len(albedo))

    def sums() -> np.ndarray:
        return factors * (even @ (weights * factors).astype(even.dtype))

    for _ in range(3):
        factors *= np.sqrt(np.minimum(albedo / np.maximum(sums(), 1e-30), 1))
    return factors, np.clip(albedo - sums(), 0, 1)


def bottom_modes(f: Brdf, edges: Edges = ()) -> np.ndarray:
    """Modes (C, H, N, N) of a BRDF; albedos above its `ceilings` count as these."""
    own = grid(edges)
    values = f(*own.pairs()).astype(np.float64)
    albedo = np.minimum(albedos(f, own.cosines), ceilings(f))
    return np.stack([own.brdf_modes(*column) for column in zip(values.T, albedo.T, strict=True)])


@functools.lru_cache(maxsize=16)
def interface_modes(alpha: float, eta: float, edges: Edges = ()) -> np.ndarray:
    """Modes (H, N, N) of the reflection of an interface from below; eta: below over above."""
    own = grid(edges)
    wi, wo = _dense_pairs(edges)
    h = microfacet.half_vector(wi, wo, NUMPY)
    lobe = microfacet.lobe_shape(np.float32(alpha), wi, wo, h, NUMPY)
    lobe *= fresnel.exact(microfacet.facet_cosine(h, NUMPY), np.float32(1 / eta), None, NUMPY)

    def albedo(fine: Grid) -> np.ndarray:
        return inner_albedo(in_plane(fine.cosines.astype(np.float32)[:, None]), alpha, eta)

    return own.brdf_modes(lobe, own.averaged(albedo, FINE))


@functools.lru_cache(maxsize=4)
def _dense_pairs(edges: Edges) -> tuple[Components, Components]:
    wi, wo = grid(edges).pairs(DENSE)
    return Components(*wi.T.copy()), Components(*wo.T.copy())


def mirror(alpha: float, eta: float, edges: Edges) -> np.ndarray:
    """The share (M, 1) of light at `MIRROR_COSINES` that an interface mirrors from below.

    eta: below over above.
    """
    own, modes = grid(edges), interface_modes(alpha, eta, edges)
    share = own.mirror_shares(modes) / np.maximum(modes[0] @ own.weights, 1e-9)
    fresnel_term = fresnel.dielectric(MIRROR_COSINES, np.float32(1 / eta), NUMPY)[0]
    return fresnel_term[:, None] * own.at_cosines(share[:, None])


def interreflection(
    depths: Sequence[float], upper: np.ndarray, lower: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sums of light over all its reflections by two surfaces: float32 (M, C) at `MIRROR_COSINES`.

    Args:
        depths: (C,) optical depths of the medium between the surfaces.
        upper, lower: (M, C) or (M, 1) shares of light at `MIRROR_COSINES` that the surfaces mirror.

    Returns:
        The share of entering light that crosses the medium; and the root of the sum without
        attenuation, a factor of each direction of light that the lower surface reflects.
    """
    left = np.exp(-np.asarray(depths, np.float32) / MIRROR_COSINES[:, None])
    sums = 1 / (1 - upper * lower * left * left)
    return left * sums, np.sqrt(sums)


def media_transport(
    bottom: np.ndarray, layers: Iterable[Sequence[float]], own: Grid
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Light in media, top to bottom, over a bottom of modes (H, N, N), below nothing else.

    Returns:
        The share (N,) of light that crosses the media unscattered; modes (H, N, N) of shares of
        light from the top that arrive at the bottom, and that leave the top; and the optical depth
        that attenuates unscattered light.
    """
    one = np.eye(len(own.cosines))
    up, down, depth = bottom * own.weights, np.broadcast_to(one, bottom.shape), 0.0
    for layer in reversed(list(layers)):
        albedo, sigma_t, g = resolved(*layer)
        depth, through = depth + sigma_t, np.exp(-sigma_t / own.cosines)
        if albedo * sigma_t <= LEAST_SCATTERING:
            up, down = through[:, None] * up * through, down * through
            continue
        up, field = covered(up, through, [x * own.weights for x in medium(albedo, sigma_t, g, own)])
        down = down @ field
    return np.exp(-depth / own.cosines), down, up, depth


def convergent(up: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Light that a bottom reflects, scaled down if it would grow without bound below a surface.

    Some BRDFs gain energy, such as that of white `principled`.

    Args:
        up, above: (..., N, N) shares of light that the bottom and the surface reflect.
    """
    if up[0].sum(axis=-1).max() < CONSERVING:
        return up
    gain = np.abs(np.linalg.eigvals(up[0] @ above[0])).max()
    return up * up.dtype.type(LARGEST_GAIN / max(gain, LARGEST_GAIN))


def covered(
    up: np.ndarray, through: np.ndarray, scattered: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Light that leaves a medium over a bottom, and that arrives at the bottom: (..., N, N).

    Args:
        up: (..., N, N) shares of light that the bottom reflects.
        through: (N,) shares that cross the medium unscattered.
        scattered: what the medium reflects and passes, as `up`.
    """
    reflected, passed = scattered
    once = np.diag(through) + passed
    up = convergent(up, reflected)
    field = np.linalg.solve(np.eye(len(through), dtype=up.dtype) - reflected @ up, once)
    return once @ up @ field + reflected, field


def enclosed(up: np.ndarray, interface: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """BRDF (..., N, N) of a bottom, of `covered`, below an interface that reflects from below."""
    up = convergent(up, interface * weights)
    once = up @ (interface * weights)
    return np.linalg.solve(np.eye(len(weights), dtype=up.dtype) - once, up / weights)


def seen_inside(
    bottom: np.ndarray, interface: np.ndarray, layers: Iterable[Sequence[float]], edges: Edges = ()
) -> tuple[np.ndarray, float]:
    """BRDF of a bottom and media below an interface that reflects from below.

    Args:
        bottom, interface: modes (H, N, N).
        layers: albedo, sigma_t and g of the media, top to bottom.
        edges: of the grid.

    Returns:
        Values (N, N, H) [1/sr] of all light except that reflected once, by the bottom or by the
        media (`reflected_once`), and that both surfaces mirror, any number of times
        (`interreflection`); and the optical depth that attenuates light from the bottom.
    """
    layers = [resolved(*layer) for layer in layers]
    own = grid(edges)
    through, _, up, depth = media_transport(bottom, layers, own)
    every = enclosed(up, interface, own.weights)
    mirrored = own.mirror_shares(interface) * own.mirror_shares(bottom)
    left = through * np.sqrt(1 / (1 - mirrored * through**2))
    values = own.values_of_modes(every - left[:, None] * bottom * left)
    return values - reflected_once_on_grid(layers, own), depth


def reflected_once(
    media: Iterable[Sequence[Any]], wi_z: Any, wo_z: Any, cosine: Any, xp: Namespace = NUMPY
) -> tuple[Any, Any]:
    """f [1/sr] of light that media scatter once (Chandrasekhar 1960), and the share that is left.

    Args:
        media: albedo, sigma_t and g of each, `resolved`, top to bottom.
        wi_z, wo_z: cosines of both directions to the normal. cosine: between them.

    Returns:
        f; and the share of light that crosses all media unscattered, there and back.
    """
    f, left, path = 0.0, 1.0, 1 / wi_z + 1 / wo_z
    for albedo, sigma_t, g in media:
        kept = xp.exp(-sigma_t * path)
        f = f + left * albedo * (1 - kept) * hg(-cosine, g, xp) / (wi_z + wo_z)
        left = left * kept
    return f, left


def reflected_once_on_grid(layers: Iterable[Sequence[float]], own: Grid) -> np.ndarray:
    """Values (N, N, H) [1/sr] of light that media, `resolved`, scatter once, as `medium` has it."""
    a, b, between = own.cosines[:, None, None], own.cosines[:, None], own.dots()
    total, left = np.zeros_like(between), np.ones_like(between)
    for albedo, sigma_t, g in layers:
        once, kept = reflected_once([(albedo, sigma_t, g)], a, b, between)
        if albedo * sigma_t > LEAST_SCATTERING:
            total += left * once * _thin_layer(sigma_t, g, own)[0].factors[..., None]
        left *= kept
    return total


def passed_inside(
    bottom: np.ndarray, interface: np.ndarray, layers: Iterable[Sequence[float]], edges: Edges
) -> tuple[np.ndarray, np.ndarray, float]:
    """Transmission of media over a bottom, below an interface that reflects from below.

    Args:
        bottom, interface, layers, edges: as of `seen_inside`.

    Returns:
        Modes (H, N, N): shares of light that crosses the media, in either direction, from the
        first nodes to the second; of it (N,) what goes straight, not scattered and at most mirrored
        (`Grid.mirror_shares`); and the optical depth that attenuates straight light.
    """
    own = grid(edges)
    through, down, up, depth = media_transport(bottom, layers, own)
    every = down @ np.linalg.inv(np.eye(len(through)) - (interface * own.weights) @ up)
    mirrored = own.mirror_shares(interface) * own.mirror_shares(bottom)
    return every, through / (1 - mirrored * through**2), depth


def resolved(albedo: float, sigma_t: float, g: float) -> tuple[float, float, float]:
    """A similar medium whose phase function the grid resolves.

    By Joseph, Wiscombe and Weinman (1976).
    """
    if g > LARGEST_ASYMMETRY:
        ahead = (g - LARGEST_ASYMMETRY) / (1 - LARGEST_ASYMMETRY)
        left = 1 - albedo * ahead
        albedo, sigma_t, g = albedo * (1 - ahead) / left, sigma_t * left, LARGEST_ASYMMETRY
    return albedo, sigma_t, max(g, RESOLVED_G)


class _ThinLayer(NamedTuple):
    """A layer of a medium of albedo 1 that scatters once."""

    through: np.ndarray  # (N,) shares of unscattered light
    reflected: np.ndarray  # modes (M, N, N), the first ones, over the factors
    passed: np.ndarray  # the same
    factors: np.ndarray  # (N, N), which give the sums over directions that they should have


@functools.lru_cache(maxsize=4)
def _thin_layer(sigma_t: float, g: float, own: Grid) -> tuple[_ThinLayer, int]:
    """The layer with which doubling begins, and how often it is doubled."""
    cosines, weights = own.cosines, own.weights
    count = max(int(np.ceil(np.log2(sigma_t / FIRST_DEPTH))), 0)
    depth = sigma_t / 2**count
    a, b = cosines[:, None], cosines
    between = own.dots()
    back, forth = (own.modes(hg(sign * between, g, NUMPY)) for sign in (-1, 1))
    sizes = np.abs(np.stack([back, forth])).max(axis=(0, 2, 3))  # they vanish from some order on
    orders = int(np.flatnonzero(sizes > LEAST_MODE * sizes[0])[-1]) + 1
    same = np.isclose(a, b, rtol=0, atol=1e-9)
    kept = (np.exp(-depth / a) - np.exp(-depth / b)) / np.where(same, 1, a - b)
    reflected = back[:orders] * (-np.expm1(-depth * (1 / a + 1 / b)) / (a + b))
    passed = forth[:orders] * np.where(same, depth * np.exp(-depth / a) / (a * a), kept)
    factors = np.ones(len(cosines))
    scattered = reflected[0] + passed[0]
    for _ in range(ROUNDS):
        factors = np.sqrt(factors * -np.expm1(-depth / cosines) / (scattered @ (weights * factors)))
    through = np.exp(-depth / cosines)
    return _ThinLayer(through, reflected, passed, factors[:, None] * factors), count


@functools.lru_cache(maxsize=32)
def medium(
    albedo: float, sigma_t: float, g: float, own: Grid | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Reflection and transmission of the light that a medium scatters: modes (H, N, N) each.

    By doubling a thin layer that scatters once; its sums over directions are made exact.
    """
    own = own or grid()
    weights, one = own.weights, np.eye(len(own.cosines))
    layer, count = _thin_layer(sigma_t, g, own)
    factors, through = albedo * layer.factors, layer.through
    reflected, passed = layer.reflected * factors, layer.passed * factors
    vanishing = np.zeros((own.orders - len(reflected), *one.shape))
    for _ in range(count):
        up = np.diag(through) + passed * weights
        between = np.linalg.inv(one - (reflected * weights) @ (reflected * weights))
        twice = up @ between
        down = np.diag(through) + weights[:, None] * passed
        reflected = reflected + twice @ reflected @ down
        through = through * through
        passed = (twice @ up - np.diag(through)) / weights
    return np.concatenate([reflected, vanishing]), np.concatenate([passed, vanishing])
