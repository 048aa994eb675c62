"""Rough surfaces of single scattering: GGX with separable masking (Walter et al. 2007).

Pairs of directions (P, 3) point away from the surface; f (P,) in 1/sr.
"""

from collections.abc import Callable

import numpy as np

Fresnel = Callable[[np.ndarray], np.ndarray]


def fresnel_dielectric(cos: np.ndarray, eta: float) -> np.ndarray:
    """Unpolarised reflectance for eta = n_transmitted / n_incident; 1 beyond the critical angle."""
    cos = np.asarray(cos, np.float64)
    cos2_t = 1 - (1 - cos**2) / eta**2
    refracted = cos2_t > 0
    cos_t = np.sqrt(np.where(refracted, cos2_t, 1.0))  # beyond the critical angle any will do
    s = (cos - eta * cos_t) / (cos + eta * cos_t)
    p = (eta * cos - cos_t) / (eta * cos + cos_t)
    return np.where(refracted, 0.5 * (s**2 + p**2), 1.0)


def fresnel_conductor(cos: np.ndarray, eta: float, k: float) -> np.ndarray:
    """Unpolarised reflectance of the complex index of refraction eta + i k, seen from air."""
    n2 = (eta + 1j * k) ** 2
    cos_t = np.sqrt(n2 - (1 - cos**2))  # n cos(theta_t)
    s = (cos - cos_t) / (cos + cos_t)
    p = (n2 * cos - cos_t) / (n2 * cos + cos_t)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


def fresnel_schlick(cos: np.ndarray, r0: float) -> np.ndarray:
    """Schlick 1994, eq. 15."""
    return r0 + (1 - r0) * (1 - cos) ** 5


def facets(half: np.ndarray, wi: np.ndarray, wo: np.ndarray, alpha) -> np.ndarray:
    """D G of unit normals over the cosines of both directions, for one width or two.

    Eq. 33 and 34; Heitz 2014, eq. 85 and 86.
    """
    scale = np.array([*np.broadcast_to(alpha, 2), 1.0])
    result = 1 / (np.pi * scale.prod() * ((half / scale) ** 2).sum(1) ** 2)
    for w in wi, wo:
        result = result * 2 / (np.abs(w[:, 2]) + np.linalg.norm(w * scale, axis=1))
    return result


def reflection(wi: np.ndarray, wo: np.ndarray, alpha, fresnel: Fresnel) -> np.ndarray:
    """F D G / (4 mu_i mu_o), eq. 20; alpha is one width, or two."""
    wi, wo = wi.astype(np.float64), wo.astype(np.float64)
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    return fresnel((wi * half).sum(1)) * facets(half, wi, wo, alpha) / 4


def transmission(wi: np.ndarray, wo: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """Eq. 21 without the squared index, from wi above to wo below a surface of index eta, or back.

    Light that enters is scattered by eta**2 times this, light that leaves by this.
    """
    wi, wo = wi.astype(np.float64), wo.astype(np.float64)
    half = (wi + eta * wo) * (-1 if eta > 1 else 1)  # eq. 16, to the side of the smaller index
    length = np.linalg.norm(half, axis=1)
    half /= length[:, None]
    above, below = (wi * half).sum(1), -(wo * half).sum(1)
    seen = (half[:, 2] > 0) & (above > 0) & (below > 0)  # the front of the facet, by both
    passed = (1 - fresnel_dielectric(np.clip(above, 0, 1), eta)) * above * below / length**2
    return np.where(seen, passed * facets(half, wi, wo, alpha), 0)


FRESNEL = {
    "conductor": fresnel_schlick,
    "conductor_complex": fresnel_conductor,
    "dielectric": fresnel_dielectric,
}


def bottom(kind: str, wi: np.ndarray, wo: np.ndarray, *numbers: float) -> np.ndarray:
    """f of a kind of a table's bottoms, with its parameters."""
    if kind == "diffuse":
        return np.full(len(wi), numbers[0] / np.pi)
    widths = 2 if kind.endswith("_anisotropic") else 1
    fresnel = FRESNEL[kind.removesuffix("_anisotropic")]
    return reflection(wi, wo, numbers[:widths], lambda c: fresnel(c, *numbers[widths:]))
