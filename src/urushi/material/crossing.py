"""How light crosses a rough dielectric interface: directions inside, their weights and densities.

A facet normal m relates a direction w outside, which points away from the surface, to the direction
w' of the refracted light inside, reversed to point upwards:

    w' = w / eta + (cos_t - cos_m / eta) m,    cos_m = w.m,  cos_t = w'.m

(Walter et al. 2007, eq. 40). Facets are drawn among those visible from w (Dupuy and Benyoub 2023,
listing 1). The transmitted fraction of the light is the weight (1 - F) G1(w').

All arrays are float32 of NumPy. A `Vector` is three arrays that broadcast: x, y and z.
"""

from typing import NamedTuple

import numpy as np

from urushi.core import fresnel, microfacet
from urushi.core.namespace import NUMPY, Components

#: Components x, y and z of unit vectors.
Vector = tuple[np.ndarray, ...]

#: Least cosine of a direction inside. Light closer to the horizon does not cross.
LEAST_COSINE = np.float32(1e-4)

#: Least number in a division.
TINY = np.float32(1e-12)


class Crossing(NamedTuple):
    """Light that crosses an interface, from directions outside to directions inside."""

    inside: Vector  # the directions inside; the normal where light does not cross
    weight: np.ndarray  # transmitted fraction of the light over the density; 0 where none crosses
    density: np.ndarray  # of probability of the inner direction [1/sr], given the outer one

    def taken(self, places: np.ndarray) -> "Crossing":
        """The crossings (M,) at places of the flat arrays."""
        x, y, z, weight, density = (w.take(places) for w in (*self.inside, *self[1:]))
        return Crossing((x, y, z), weight, density)


def cross(cosine: np.ndarray, alpha: float, eta: float, u: np.ndarray) -> Crossing:
    """Let light of directions (sqrt(1 - cosine^2), 0, cosine) cross.

    Args:
        cosine: (N, 1).
        alpha: GGX width.
        eta: index inside over that outside.
        u: (K, 2) numbers in [0, 1) that choose the facets.

    Returns:
        Arrays (N, K).
    """
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0))
    facet = visible_facets(cosine, sine, alpha, u)
    cos_m = np.clip(sine * facet[0] + cosine * facet[2], TINY, 1)
    reflectance, cos_t = fresnel.dielectric(cos_m, np.float32(eta), NUMPY)
    along = cos_t - cos_m / np.float32(eta)
    x = sine / np.float32(eta) + along * facet[0]
    y = along * facet[1]
    z = cosine / np.float32(eta) + along * facet[2]
    size = 1 / np.sqrt(x * x + y * y + z * z)
    x, y, z = x * size, y * size, z * size
    present = (cos_t > 0) & (z > LEAST_COSINE)
    inside = tuple(np.where(present, w, n) for w, n in zip((x, y, z), (0, 0, 1), strict=True))
    weight = (1 - reflectance) * masking(inside[2], alpha)
    density = _density(cosine, facet, cos_m, cos_t, alpha, eta)
    return Crossing(inside, np.where(present, weight, 0), density)


def facet_points(count: int) -> np.ndarray:
    """Numbers (K, 2) for `cross`: a lattice of even heights and azimuths of the golden ratio.

    48 of them serve better than 128 `even_points`, whose mean height is off.
    """
    index = np.arange(count)
    return np.stack([index * 0.6180339887498949 % 1, (index + 0.5) / count], 1).astype(np.float32)


def facet_pair_points(count: int) -> np.ndarray:
    """Numbers (K, 4) for two crossings: a lattice of Korobov (1959), of 64 or 256 points.

    Each column is evenly spaced, and no other generator keeps the points as far apart. 64 of them
    serve better than 256 `even_points`.
    """
    index, generator = np.arange(count)[:, None], {64: 19, 256: 9}[count]
    return (((index * generator ** np.arange(4)) % count + 0.5) / count).astype(np.float32)


def crossing_at(outside: Vector, inside: Vector, alpha: float, eta: float) -> Crossing:
    """The weight and the density of given pairs of directions outside and inside."""
    sign = np.float32(1 if eta > 1 else -1)
    facet = tuple(sign * (eta * b - a) for a, b in zip(outside, inside, strict=True))
    size = np.sqrt(sum(x * x for x in facet))
    facet = tuple(x / np.maximum(size, TINY) for x in facet)
    cos_m = sum(a * m for a, m in zip(outside, facet, strict=True))
    cos_t = sum(b * m for b, m in zip(inside, facet, strict=True))
    present = (cos_m > 0) & (cos_t > 0) & (facet[2] > 0) & (inside[2] > LEAST_COSINE)
    cos_m, cos_t = np.clip(cos_m, TINY, 1), np.clip(cos_t, TINY, 1)
    reflectance = fresnel.dielectric(cos_m, np.float32(eta), NUMPY)[0]
    weight = (1 - reflectance) * masking(np.maximum(inside[2], LEAST_COSINE), alpha)
    density = _density(outside[2], facet, cos_m, cos_t, alpha, eta)
    return Crossing(inside, np.where(present, weight, 0), np.where(present, density, 0))


def mirrored(
    cosine: np.ndarray, alpha: float, eta: float, u: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Light that an interface mirrors: cosines (N, K), and fractions (N, K) over the density.

    The arguments are those of `cross`.
    """
    sine = np.sqrt(np.maximum(1 - cosine * cosine, 0))
    facet = visible_facets(cosine, sine, alpha, u)
    cos_m = np.clip(sine * facet[0] + cosine * facet[2], TINY, 1)
    z = 2 * cos_m * facet[2] - cosine
    reflectance = fresnel.dielectric(cos_m, np.float32(eta), NUMPY)[0]
    weight = reflectance * masking(np.maximum(z, LEAST_COSINE), alpha)
    return z, np.where(z > LEAST_COSINE, weight, 0)


def inner_albedo(cosine: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """The share (N,) of light of cosines (N,) inside that the interface reflects back inside."""
    column = cosine.astype(np.float32)[:, None]
    return mirrored(column, alpha, 1 / eta, facet_points(256))[1].mean(axis=1, dtype=np.float64)


def visible_facets(cosine: np.ndarray, sine: np.ndarray, alpha: float, u: np.ndarray) -> Vector:
    """Facet normals (N, K) that are visible from directions (sine, 0, cosine) (N, 1); u: (K, 2)."""
    width = np.float32(alpha)
    w = microfacet.stretched(Components(sine, 0.0, cosine), width, NUMPY)
    m = microfacet.cap_normal(w, width, (1 - u[:, 1]) * (1 + w.z) - w.z, u[:, 0], NUMPY)
    z = np.maximum(m.z, 0)
    size = 1 / np.sqrt(np.maximum(m.x * m.x + m.y * m.y + z * z, TINY))
    return m.x * size, m.y * size, z * size


def masking(cosine: np.ndarray, alpha: float) -> np.ndarray:
    """Smith's G1 of GGX (Walter et al. 2007, eq. 34)."""
    square = cosine * cosine
    return 2 * cosine / (cosine + np.sqrt(square + np.float32(alpha * alpha) * (1 - square)))


def _density(
    cosine: np.ndarray,
    facet: Vector,
    cos_m: np.ndarray,
    cos_t: np.ndarray,
    alpha: float,
    eta: float,
) -> np.ndarray:
    """The density of directions inside [1/sr] (Walter et al. 2007, eqs. 17 and 33)."""
    square = np.float32(alpha * alpha)
    spread = facet[0] * facet[0] + facet[1] * facet[1] + square * (facet[2] * facet[2])
    normals = square / (np.float32(np.pi) * spread * spread)
    visible = masking(cosine, alpha) * normals * cos_m / cosine
    change = eta * cos_t - cos_m
    return visible * np.float32(eta * eta) * cos_t / np.maximum(change * change, TINY)
