"""The base of OpenPBR Surface 1.1.1 (section 3.2) in NumPy, its albedos by sums over facets.

It shares no code with the package: GGX with the separable masking of Smith, F82-tint with the lobe
of Kulla and Conty 2017 for metals, a Lambertian slab below the interface for dielectrics.
"""

from collections.abc import Callable

import numpy as np
from tests.oracles.surfaces import fresnel_dielectric as dielectric

#: Facets of an albedo, and cosines and azimuths of its mean.
FACETS, COSINES, AZIMUTHS = 1 << 12, 16, 4

Fresnel = Callable[[np.ndarray], np.ndarray]


def base(p: dict[str, np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f (N, 3) [1/sr] of one material at pairs (N, 3) above the horizon; p: its parameters."""
    rough, ratio = p["specular_roughness"], 1 - p["specular_roughness_anisotropy"]
    along = rough**2 * np.sqrt(2 / (1 + ratio**2))
    widths = np.clip([along, ratio * along], 0.01, 1).ravel()
    weight, share, tint = p["specular_weight"], p["base_metalness"], p["specular_color"]
    root = (p["specular_ior"] - 1) / (p["specular_ior"] + 1) * np.sqrt(weight)
    eta, color = np.clip((1 + root) / (1 - root), 1 / 3, 3), p["base_weight"] * p["base_color"]
    half = wi + wo
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    cosine = (half * wi).sum(-1)
    scaled = half / [*widths, 1]
    facets = 1 / (np.pi * widths.prod() * (scaled**2).sum(-1) ** 2)
    lobe = facets * masking(wi, widths) * masking(wo, widths) / (4 * wi[:, 2] * wo[:, 2])

    def diffuse(fresnel: Fresnel) -> np.ndarray:
        """The lobe of what an interface does not reflect at once, of albedo one where it is."""
        lost = [np.array([1 - albedo(w, widths, fresnel) for w in ws]) for ws in (wi, wo)]
        return (lost[0] * lost[1] / (np.pi * (1 - mean_albedo(widths, fresnel))))[:, None]

    glass = (lobe * dielectric(cosine, eta))[:, None] * tint
    glass = glass + color * diffuse(lambda c: dielectric(c, eta))
    x, weights = (0.5 * x for x in np.polynomial.legendre.leggauss(64))
    x = x[:, None] + 0.5
    mean = (2 * weights[:, None] * x * f82(x, color, tint)).sum(0)
    seen = mean_albedo(widths, np.ones_like)
    more = mean**2 * seen / (1 - mean * (1 - seen)) * diffuse(np.ones_like)
    metal = lobe[:, None] * f82(cosine[:, None], color, tint) + more
    return (1 - share) * glass + share * np.minimum(weight, 1) * metal


def f82(cosine: np.ndarray, f0: np.ndarray, tint: np.ndarray) -> np.ndarray:
    """Schlick's term less a dip, which leaves the share `tint` of it at a cosine of 1 / 7."""
    edge = f0 + (1 - f0) * (6 / 7) ** 5
    dip = edge * (1 - tint) * 7 * (7 / 6) ** 6 * cosine * (1 - cosine) ** 6
    return np.maximum(f0 + (1 - f0) * (1 - cosine) ** 5 - dip, 0)


def masking(w: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Smith's masking (N,) of directions (N, 3)."""
    slope2 = ((widths * w[:, :2]) ** 2).sum(-1) / w[:, 2] ** 2
    return 2 / (1 + np.sqrt(1 + slope2))


def albedo(w: np.ndarray, widths: np.ndarray, fresnel: Fresnel) -> float:
    """Share of the light from w (3,) that one reflection by the facets lets leave.

    A mean over visible facets (Heitz 2018, Sampling the GGX distribution of visible normals).
    """
    index = np.arange(FACETS) + 0.5
    u, turn = index / FACETS, 2 * np.pi * (index * 0.6180339887498949 % 1)
    v = w * [*widths, 1]
    v /= np.linalg.norm(v)
    first = np.array([-v[1], v[0], 0]) if np.hypot(*v[:2]) > 1e-9 else np.array([1.0, 0, 0])
    first /= np.linalg.norm(first)
    x, y, part = np.sqrt(u) * np.cos(turn), np.sqrt(u) * np.sin(turn), 0.5 * (1 + v[2])
    y = (1 - part) * np.sqrt(1 - x**2) + part * y
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    half = x[:, None] * first + y[:, None] * np.cross(v, first) + z[:, None] * v
    half *= [*widths, 1]
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    cosine = (half * w).sum(-1)
    out = 2 * cosine[:, None] * half - w
    leaves = out[:, 2] > 0
    return (masking(out[leaves], widths) * fresnel(cosine[leaves])).sum() / FACETS


def mean_albedo(widths: np.ndarray, fresnel: Fresnel) -> float:
    """Mean of `albedo` over diffuse light."""
    nodes, weights = np.polynomial.legendre.leggauss(COSINES)
    turns = (np.arange(AZIMUTHS) + 0.5) * np.pi / (2 * AZIMUTHS)
    total = 0.0
    for c, weight in zip(0.5 * (nodes + 1), weights, strict=True):
        sine = np.sqrt(1 - c * c)
        for turn in turns[: 1 if widths[0] == widths[1] else None]:
            w = np.array([sine * np.cos(turn), sine * np.sin(turn), c])
            found = albedo(w, widths, fresnel)
            total += weight * c * found / (1 if widths[0] == widths[1] else AZIMUTHS)
    return total
