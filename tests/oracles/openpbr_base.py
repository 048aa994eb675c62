"""The base of OpenPBR Surface 1.1.1 (section 3.2) in NumPy.

Its formulas are not the package's: GGX with the separable masking of Smith, F82-tint with the lobe
of Kulla and Conty 2017 for metals, a Lambertian slab below the interface for dielectrics.
"""

import numpy as np
from tests.directions import at_cosines
from tests.oracles.surfaces import Fresnel, reflection
from tests.oracles.surfaces import fresnel_dielectric as dielectric

from urushi.core.quadrature import directional_albedos

#: Cosines and azimuths of the mean of an albedo.
COSINES, AZIMUTHS = 16, 4


def base(p: dict[str, np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f (N, 3) [1/sr] of one material at pairs (N, 3) above the horizon; p: its parameters."""
    rough, ratio = p["specular_roughness"], 1 - p["specular_roughness_anisotropy"]
    along = rough**2 * np.sqrt(2 / (1 + ratio**2))
    widths = np.clip([along, ratio * along], 0.01, 1).ravel()
    weight, share, tint = p["specular_weight"], p["base_metalness"], p["specular_color"]
    root = (p["specular_ior"] - 1) / (p["specular_ior"] + 1) * np.sqrt(weight)
    eta, color = np.clip((1 + root) / (1 - root), 1 / 3, 3), p["base_weight"] * p["base_color"]
    cosine = np.sqrt(0.5 + 0.5 * (wi * wo).sum(-1))
    lobe = reflection(wi, wo, widths, np.ones_like)

    def diffuse(fresnel: Fresnel) -> np.ndarray:
        """The lobe of what an interface does not reflect at once, of albedo one where it is."""
        lost = [1 - albedo(w, widths, fresnel) for w in (wi, wo)]
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


def albedo(w: np.ndarray, widths: np.ndarray, fresnel: Fresnel) -> np.ndarray:
    """Shares (N,) of the light from w (N, 3) that one reflection by the facets lets leave."""

    def lobe(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return reflection(a, b, widths, fresnel)

    return directional_albedos(lobe, w, anisotropic=widths[0] != widths[1])[:, 0]


def mean_albedo(widths: np.ndarray, fresnel: Fresnel) -> float:
    """Mean of `albedo` over diffuse light."""
    nodes, weights = np.polynomial.legendre.leggauss(COSINES)
    cosines, turns = 0.5 * (nodes + 1), (np.arange(AZIMUTHS) + 0.5) * np.pi / (2 * AZIMUTHS)
    w = at_cosines(cosines[:, None], turns if widths[0] != widths[1] else 0.0)
    found = albedo(w.reshape(-1, 3), widths, fresnel).reshape(COSINES, -1).mean(axis=1)
    return (weights * cosines) @ found
