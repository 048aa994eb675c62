"""How light crosses a rough dielectric interface: directions inside, their weights and densities.

A facet normal m relates a direction w outside, which points away from the surface, to the direction
w' of the refracted light inside, reversed to point upwards:

    w' = w / eta + (cos_t - cos_m / eta) m,    cos_m = w.m,  cos_t = w'.m

(Walter et al. 2007, eq. 40). Facets are drawn among those visible from w (Dupuy and Benyoub 2023,
listing 1). The transmitted fraction of the light is the weight (1 - F) G1(w').

Directions are `Components` that broadcast. A width `alpha` is one number or two `Widths` along x
and y (Heitz 2014, section 5.4). All arrays are float32 of NumPy; those functions that take a
`Namespace`, `xp`, serve Dr.Jit too, whose directions are `Array3f`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core import fresnel, microfacet
from urushi.core.namespace import NUMPY, Components, Namespace

#: Least cosine of a direction inside. Light closer to the horizon does not cross.
LEAST_COSINE = 1e-4

#: Generators of lattices (Korobov 1959) by their number of points: they keep the points far apart,
#: and of those of 512 points the best one for narrow lobes.
GENERATORS = {64: 19, 256: 9, 512: 229}

#: Least number in a division.
TINY = 1e-12


class Crossing(NamedTuple):
    """Light that crosses an interface, from directions outside to directions inside."""

    inside: Any  # the directions inside; the normal where light does not cross
    weight: Any  # transmitted fraction of the light over the density; 0 where none crosses
    density: Any  # of probability of the inner direction [1/sr], given the outer one


def cross(
    outside: Any, alpha: Any, eta: Any, u: np.ndarray | Sequence, xp: Namespace = NUMPY
) -> Crossing:
    """Let light of directions cross.

    Args:
        outside: (N, 1), above the horizon.
        alpha: GGX width or widths.
        eta: index inside relative to outside.
        u: (K, 2) or (N, K, 2) numbers in [0, 1) that choose the facets, or a list of both columns.

    Returns:
        Arrays (N, K).
    """
    eta, facet = _single(eta), visible_facets(outside, alpha, u, xp)
    cos_m = xp.clip(_dot(outside, facet), TINY, 1)
    reflectance, cos_t = fresnel.dielectric(cos_m, eta, xp)
    along = cos_t - cos_m / eta
    x, y, z = (w / eta + along * m for w, m in zip(outside, facet, strict=True))
    size = 1 / xp.sqrt(x * x + y * y + z * z)
    x, y, z = x * size, y * size, z * size
    present = (cos_t > 0) & (z > LEAST_COSINE)
    inside = kept(type(outside)(x, y, z), present, xp)
    weight = (1 - reflectance) * masking(inside, alpha, xp)
    density = _density(outside, facet, cos_m, cos_t, alpha, eta, xp)
    return Crossing(inside, xp.where(present, weight, 0), density)


def kept(w: Any, present: Any, xp: Namespace = NUMPY) -> Any:
    """Directions where they are present, elsewhere the normal."""
    return type(w)(*(xp.where(present, x, n) for x, n in zip(w, (0, 0, 1), strict=True)))


def in_plane(cosine: np.ndarray) -> Components:
    """Directions of cosines (...) in the xz plane."""
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0))
    return Components(sine, np.zeros_like(sine), cosine)


def facet_points(count: int) -> np.ndarray:
    """Numbers (K, 2) for `cross`: a lattice of even heights and azimuths of the golden ratio.

    48 of them serve better than 128 `even_points`, whose mean height is off.
    """
    index = np.arange(count)
    return np.stack([index * 0.6180339887498949 % 1, (index + 0.5) / count], 1).astype(np.float32)


def crossing_at(outside: Any, inside: Any, alpha: Any, eta: Any, xp: Namespace = NUMPY) -> Crossing:
    """The weight and the density of given pairs of directions outside and inside."""
    eta = _single(eta)
    sign = (eta - 1) / xp.absolute(eta - 1)
    x, y, z = (sign * (eta * b - a) for a, b in zip(outside, inside, strict=True))
    size = xp.maximum(xp.sqrt(x * x + y * y + z * z), TINY)
    facet = type(outside)(x / size, y / size, z / size)
    cos_m, cos_t = _dot(outside, facet), _dot(inside, facet)
    present = (cos_m > 0) & (cos_t > 0) & (facet.z > 0) & (inside.z > LEAST_COSINE)
    cos_m, cos_t = xp.clip(cos_m, TINY, 1), xp.clip(cos_t, TINY, 1)
    reflectance = fresnel.dielectric(cos_m, eta, xp)[0]
    x, y, z = inside
    weight = (1 - reflectance) * masking((x, y, xp.maximum(z, LEAST_COSINE)), alpha, xp)
    density = _density(outside, facet, cos_m, cos_t, alpha, eta, xp)
    return Crossing(inside, xp.where(present, weight, 0), xp.where(present, density, 0))


class Mirrored(NamedTuple):
    """Light that facets mirror, from directions outside."""

    outwards: Components  # the mirrored directions
    cosine: np.ndarray  # of either direction to the facet
    masking: np.ndarray  # share that no other facet blocks, over the density; 0 below the horizon


def mirrored(outside: Components, alpha: Any, u: np.ndarray) -> Mirrored:
    """Let visible facets mirror light; arguments and result are as of `cross`.

    The mean of reflectance times masking is the albedo (Heitz and d'Eon 2014).
    """
    facet = visible_facets(outside, alpha, u)
    cos_m = np.clip(_dot(outside, facet), TINY, 1)
    x, y, z = (2 * cos_m * m - w for w, m in zip(outside, facet, strict=True))
    seen = masking((x, y, np.maximum(z, LEAST_COSINE)), alpha)
    return Mirrored(Components(x, y, z), cos_m, np.where(z > LEAST_COSINE, seen, 0))


def inner_albedo(inside: Components, alpha: float | Widths, eta: float) -> np.ndarray:
    """The share (N,) of light of directions (N, 1) inside that the interface reflects back."""
    _, cosine, unblocked = mirrored(inside, alpha, facet_points(256))
    reflectance = fresnel.dielectric(cosine, np.float32(1 / eta), NUMPY)[0]
    return (reflectance * unblocked).mean(axis=1, dtype=np.float64)


def visible_facets(outside: Any, alpha: Any, u: Any, xp: Namespace = NUMPY) -> Any:
    """Facet normals (N, K) that are visible from directions (N, 1); u: as of `cross`."""
    width = microfacet.of_widths(_single, alpha)
    u1, u2 = (u[..., 0], u[..., 1]) if isinstance(u, np.ndarray) else u
    m = microfacet.visible_normal(width, outside, u1, u2, xp)
    z = xp.maximum(m.z, 0)
    size = 1 / xp.sqrt(xp.maximum(m.x * m.x + m.y * m.y + z * z, TINY))
    return type(outside)(m.x * size, m.y * size, z * size)


def masking(w: Any, alpha: Any, xp: Namespace = NUMPY) -> Any:
    """Smith's G1 of GGX (Walter et al. 2007, eq. 34; Heitz 2014, eq. 80)."""
    x, y, z = w
    if isinstance(alpha, Widths):
        along, across = _single(alpha.u) * x, _single(alpha.v) * y
        stretched2 = along * along + across * across
    else:
        stretched2 = _single(alpha * alpha) * (1 - z * z)
    return 2 * z / (z + xp.sqrt(z * z + stretched2))


def _density(
    outside: Any, facet: Any, cos_m: Any, cos_t: Any, alpha: Any, eta: Any, xp: Namespace
) -> Any:
    """The density of directions inside [1/sr] (Walter et al. 2007, eqs. 17 and 33)."""
    width = microfacet.of_widths(_single, alpha)
    square = microfacet.product(width)
    spread = microfacet.squeezed_sine2(facet, width) + square * (facet.z * facet.z)
    normals = square / (np.pi * (spread * spread))
    visible = masking(outside, alpha, xp) * normals * cos_m / outside.z
    change = eta * cos_t - cos_m
    return visible * (eta * eta) * cos_t / xp.maximum(change * change, TINY)


def _single(x: Any) -> Any:
    """A number in single precision, as arrays are."""
    return np.float32(x) if isinstance(x, (int, float, np.floating)) else x


def _dot(a: Any, b: Any) -> Any:
    return a.x * b.x + a.y * b.y + a.z * b.z
