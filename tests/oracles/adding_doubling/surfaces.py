"""Rough surfaces as kernels of cosines and azimuth: GGX, separable Smith, single scattering.

Formulae of Walter et al. 2007, in scalar products only. cos_phi is the cosine of the
azimuth between the directions of propagation, 1 for a mirror and for straight transmission.
"""

from collections.abc import Callable

import numpy as np
from tests.oracles.adding_doubling.quadrature import Kernel


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


def _ggx(cos2: np.ndarray, alpha: float) -> np.ndarray:
    """Walter et al. 2007, eq. 33, from the squared cosine of the microfacet normal."""
    return alpha**2 / (np.pi * (1 - cos2 + alpha**2 * cos2) ** 2)


def _smith(mu: np.ndarray, alpha: float) -> np.ndarray:
    """Walter et al. 2007, eq. 34."""
    return 2 * mu / (mu + np.sqrt(mu**2 + alpha**2 * (1 - mu**2)))


def _horizontal(mu_a: np.ndarray, mu_b: np.ndarray, cos_phi: np.ndarray) -> np.ndarray:
    """Scalar product of the components of two directions in the surface."""
    return np.sqrt((1 - mu_a**2) * (1 - mu_b**2)) * cos_phi


def _reflection(
    mu_o: np.ndarray,
    mu_i: np.ndarray,
    cos_phi: np.ndarray,
    alpha: float,
    fresnel: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """F D G / (4 mu_i mu_o): Walter et al. 2007, eq. 20."""
    # The propagation of the incident light is opposite to the direction that points away.
    one_plus_dot = np.maximum(1 + mu_o * mu_i - _horizontal(mu_o, mu_i, cos_phi), 1e-300)
    cos2_half = np.minimum((mu_o + mu_i) ** 2 / (2 * one_plus_dot), 1.0)
    shape = _ggx(cos2_half, alpha) * _smith(mu_o, alpha) * _smith(mu_i, alpha)
    cos_d = np.sqrt(np.minimum(one_plus_dot / 2, 1.0))
    return fresnel(cos_d) * shape / (4 * mu_o * mu_i)


def outer_reflection(alpha: float, eta: float) -> Kernel:
    """Reflection of a rough dielectric from above; total reflection too if eta < 1."""
    return lambda o, i, c: _reflection(o, i, c, alpha, lambda d: fresnel_dielectric(d, eta))


def inner_reflection(alpha: float, eta: float) -> Kernel:
    """Reflection of a rough dielectric from below; total reflection too if eta > 1."""
    return lambda o, i, c: _reflection(o, i, c, alpha, lambda d: fresnel_dielectric(d, 1 / eta))


def conductor_schlick(alpha: float, r0: float) -> Kernel:
    """Rough conductor with Schlick's Fresnel term."""
    return lambda o, i, c: _reflection(o, i, c, alpha, lambda d: fresnel_schlick(d, r0))


def conductor_complex(alpha: float, eta: float, k: float) -> Kernel:
    """Rough conductor with a complex index of refraction, in air."""
    return lambda o, i, c: _reflection(o, i, c, alpha, lambda d: fresnel_conductor(d, eta, k))


def lambertian(reflectance: float) -> Kernel:
    """Ideally diffuse reflector."""
    return lambda o, i, c: np.broadcast_to(
        reflectance / np.pi, np.broadcast_shapes(o.shape, i.shape, c.shape)
    )


#: Kernels of bottoms by the kinds of a table, with its parameters as their arguments.
BOTTOMS = {
    "conductor": conductor_schlick,
    "conductor_complex": conductor_complex,
    "dielectric": outer_reflection,
    "diffuse": lambertian,
}


def at_pairs(kernel: Kernel, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """A kernel (P,) at directions (P, 3) that point away from the surface, on one side of it."""
    wi, wo = wi.astype(np.float64), wo.astype(np.float64)
    lengths = np.hypot(wi[:, 0], wi[:, 1]) * np.hypot(wo[:, 0], wo[:, 1])
    cos_phi = -(wi[:, :2] * wo[:, :2]).sum(1) / np.maximum(lengths, 1e-300)
    return kernel(wi[:, 2], wo[:, 2], cos_phi)


def transmission(alpha: float, eta: float) -> Kernel:
    """The symmetric kernel S of transmission between outside (first) and inside cosines.

    Light entering is scattered by eta**2 S, light leaving by S (Walter et al. 2007, eq. 21 without
    eta_o**2), so that eta**2 S ... S is reciprocal and conserves flux.
    """

    def kernel(mu_out: np.ndarray, mu_in: np.ndarray, cos_phi: np.ndarray) -> np.ndarray:
        dot = -(mu_out * mu_in + _horizontal(mu_out, mu_in, cos_phi))
        length2 = np.maximum(1 + eta**2 + 2 * eta * dot, 1e-300)  # of out + eta in, eq. 16
        # The normal that points to the side of the smaller index is -(out + eta in).
        sign = 1 if eta > 1 else -1
        half_z = sign * (eta * mu_in - mu_out)
        out_half = -sign * (1 + eta * dot) / np.sqrt(length2)
        in_half = sign * (dot + eta) / np.sqrt(length2)
        # Both directions must see the front of the microfacet, else Smith's G1 is zero.
        valid = (half_z > 0) & (out_half > 0) & (in_half > 0)
        out_half = np.clip(out_half, 0.0, 1.0)
        shape = _ggx(np.minimum(half_z**2 / length2, 1.0), alpha)
        shape = shape * _smith(mu_out, alpha) * _smith(mu_in, alpha)
        passed = (1 - fresnel_dielectric(out_half, eta)) * out_half * in_half
        return np.where(valid, passed * shape / (mu_out * mu_in * length2), 0.0)

    return kernel
