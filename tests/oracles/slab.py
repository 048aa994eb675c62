"""Closed forms of a smooth dielectric slab that absorbs: free, over a mirror or a Lambertian.

The limit of the layered model for alpha -> 0 without scattering, in NumPy float64, without code of
the random walk. Monochrome; all cosines are those in air, in (0, 1]. The index of the slab relative
to that of the outside is above or below one; below one, grazing light is totally reflected. The
reflectance of an interface is the same from inside at the refracted angle.
"""

import numpy as np
import numpy.typing as npt
from scipy import integrate
from tests.oracles.surfaces import Fresnel
from tests.oracles.surfaces import fresnel_dielectric as interface_reflectance


def refracted(cos: npt.ArrayLike, eta: float) -> np.ndarray:
    """Cosine inside a slab of index eta, by Snell's law; 0 under total reflection."""
    return np.sqrt(np.maximum(1 - (1 - np.asarray(cos, np.float64) ** 2) / eta**2, 0.0))


def _transmittance(sigma_t: float, cos: np.ndarray) -> np.ndarray:
    """Beer's law for one crossing at the cosine inside; 1 where no light enters."""
    return np.exp(-sigma_t / np.where(cos > 0, cos, np.inf))


def smooth(
    cos: npt.ArrayLike, eta: float, sigma_t: float, below: Fresnel
) -> tuple[np.ndarray, np.ndarray]:
    """Reflected and transmitted share of the light on a slab (Stokes 1862; Airy, incoherent).

    Args:
        cos: incident cosines, any shape.
        eta: index of the slab relative to the outside, not 1.
        sigma_t: its optical depth, albedo 0.
        below: what its bottom, a smooth interface or conductor, reflects at cosines inside.
    """
    first, inside = interface_reflectance(cos, eta), refracted(cos, eta)
    last, through = below(inside), _transmittance(sigma_t, inside)
    # Under total reflection the geometric series may be 0 / 0.
    left = (1 - first) / np.where(first < 1, 1 - first * last * through**2, 1)
    return first + left * (1 - first) * last * through**2, left * (1 - last) * through


def internal_return(eta: float, sigma_t: float = 0.0) -> float:
    """Fraction of Lambertian light that a slab returns to the bottom it came from.

    The integral of 2 mu F(mu) exp(-2 sigma_t / mu) over the cosine mu inside. Light rises through
    the medium, is reflected by the surface and descends again. Without absorption this is the
    diffuse internal reflectance (Walsh 1926).
    """

    def returned(cos: float) -> float:
        return 2 * cos * interface_reflectance(cos, 1 / eta) * np.exp(-2 * sigma_t / cos)

    critical = np.sqrt(max(1 - 1 / eta**2, 0))  # the root of F beside it needs small intervals
    return integrate.quad(returned, 0, 1, points=[critical])[0]


def lambertian_f(
    cos_i: npt.ArrayLike, cos_o: npt.ArrayLike, eta: float, sigma_t: float, reflectance: float
) -> np.ndarray:
    """BRDF [1/sr] of an absorbing slab over a Lambertian, without the mirror reflection on top.

    f = (rho / pi) T(wi) T(wo) exp(-sigma_t / mu_i - sigma_t / mu_o) / (eta^2 (1 - rho K)), with
    K the `internal_return`: for sigma_t = 0 the formula of Wolff 1994, after Saunderson 1942.

    Args:
        cos_i, cos_o: cosines of the directions, broadcast together.
        eta, sigma_t: as for `smooth`.
        reflectance: of the Lambertian, in [0, 1].
    """
    result = np.ones(())
    for cos in (cos_i, cos_o):
        pass_in = 1 - interface_reflectance(cos, eta)
        result = result * pass_in * _transmittance(sigma_t, refracted(cos, eta))
    series = 1 - reflectance * internal_return(eta, sigma_t)
    return reflectance / (np.pi * eta**2) * result / series
