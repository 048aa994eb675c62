"""Quadrature over the hemisphere of outgoing directions that resolves any GGX-like lobe.

The energy limit has a rule with fewer nodes, `urushi.material.albedo_rule`.
"""

import functools
from collections.abc import Callable

import numpy as np

from urushi.core.directions import turned

#: Gauss-Legendre nodes in ln tan theta_h, and in each half of the range [0, pi] of the azimuth.
POLAR_NODES, AZIMUTH_NODES = 48, 16

#: Nodes in ln tan theta_h for BRDFs with an edge of total reflection. `POLAR_NODES` miss up to 0.02
#: of the albedo of an interface of index 0.5, these 0.001.
EDGE_NODES = 4 * POLAR_NODES

#: Least tan theta_h. Smaller half angles hold 1e-6 of a lobe of alpha = 0.01.
MIN_TANGENT = 1e-5

#: Nodes and weights of Gauss and Legendre in [-1, 1], by their number.
gauss = functools.cache(np.polynomial.legendre.leggauss)


def half_vector_rule(
    wi: np.ndarray,
    *,
    anisotropic: bool = False,
    azimuths: int = AZIMUTH_NODES,
    polar: int = POLAR_NODES,
) -> tuple[np.ndarray, np.ndarray]:
    """Return wo (N, M, 3) and weights (N, M): the sum of f(wo) cos_o weights integrates f cos_o.

    wi: (N, 3) unit vectors above the horizon.
    anisotropic: whether f may be. Otherwise nodes lie on one side of the plane of incidence, and
        the integrand must be the same on the other. There are four times as many nodes for
        anisotropic ones, twice as dense, because the azimuth changes them.
    azimuths: nodes in each half of the azimuth's range.
    polar: nodes in ln tan theta_h.
    """
    wi = np.asarray(wi, np.float64)
    in_plane = np.stack([np.hypot(wi[:, 0], wi[:, 1]), 0 * wi[:, 1], wi[:, 2]], axis=-1)
    nodes, weights = gauss(azimuths * (1 + anisotropic))
    quarter = 0.25 * np.pi * (nodes + 1.0)
    phi = np.concatenate([quarter, np.pi - quarter])
    phi_weight = np.tile(2.0 * 0.25 * np.pi * weights, 2)[:, None]  # both sides of the plane
    if anisotropic:
        phi, phi_weight = np.concatenate([phi, -phi]), np.tile(0.5 * phi_weight, (2, 1))
    wo, weight = half_vector_nodes(in_plane, phi, polar, MIN_TANGENT)
    weight = weight * phi_weight
    azimuth = np.arctan2(wi[:, 1], wi[:, 0])[:, None]
    return turned(wo.reshape(len(wi), -1, 3), azimuth), weight.reshape(len(wi), -1)


def directional_albedos(
    f: Callable[[np.ndarray, np.ndarray], np.ndarray],
    wi: np.ndarray,
    *,
    anisotropic: bool = False,
    azimuths: int = AZIMUTH_NODES,
    polar: int = POLAR_NODES,
) -> np.ndarray:
    """Directional albedos (N, C) of a BRDF for unit vectors wi (N, 3) above the horizon.

    f: values (M, C) [1/sr] of float32 pairs (M, 3). The other arguments are of `half_vector_rule`.
    """
    wo, weights = half_vector_rule(wi, anisotropic=anisotropic, azimuths=azimuths, polar=polar)
    pairs = np.repeat(wi, weights.shape[1], axis=0), wo.reshape(-1, 3)
    values = f(*(w.astype(np.float32) for w in pairs)).reshape(*weights.shape, -1)
    return np.einsum("nmc,nm->nc", values.astype(np.float64), weights * wo[..., 2])


def half_vector_nodes(
    wi: np.ndarray, phi: np.ndarray, count: int, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes wo (N, A, count, 3) of wi (N, 3), by half vectors at azimuths phi (A,), and weights.

    The integration variable is the half vector, logarithmic in tan theta_h from `least`, which
    resolves narrow and wide lobes. With wi = (s, 0, c) and h at (theta, phi), the cosine of wo is
    s cos(phi) sin(2 theta) + c cos(2 theta). The range of theta ends at its zero, so that all nodes
    are above the horizon and no discontinuity is integrated. The Jacobian of reflection is 4 wi.h.
    The weights (N, A, count) integrate over solid angle once the weights of phi multiply them.
    """
    x, y, z = (wi[:, i, None, None] for i in range(3))
    cos_phi, sin_phi = np.cos(phi)[:, None], np.sin(phi)[:, None]
    nodes, weights = gauss(count)
    end = 0.5 * (0.5 * np.pi + np.arctan2(x * cos_phi + y * sin_phi, z))
    first = np.log(least)
    span = np.log(np.maximum(np.tan(end), least)) - first
    tangent = np.exp(first + span * 0.5 * (nodes + 1.0))
    cos_h = 1.0 / np.sqrt(1.0 + tangent * tangent)
    sin_h = tangent * cos_h
    h = np.stack(np.broadcast_arrays(sin_h * cos_phi, sin_h * sin_phi, cos_h), axis=-1)
    dot = x * h[..., 0] + y * h[..., 1] + z * h[..., 2]
    # d(omega_h) = sin theta d(theta) d(phi), and d(theta) = sin cos d(ln tan theta)
    weight = 4.0 * dot * sin_h * sin_h * cos_h * (0.5 * span * weights)
    return 2.0 * dot[..., None] * h - wi[:, None, None], weight
