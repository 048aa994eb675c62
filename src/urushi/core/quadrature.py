"""Quadrature over the hemisphere of outgoing directions that resolves any GGX-like lobe.

The energy limit has a rule of its own with far fewer nodes, `urushi.material.albedo_rule`.
"""

import functools

import numpy as np

from urushi.core.directions import turned

#: Gauss-Legendre nodes in ln tan theta_h, and in each half of the range [0, pi] of the azimuth.
POLAR_NODES, AZIMUTH_NODES = 48, 16
#: Least tan theta_h. Smaller half angles hold 1e-6 of a lobe of alpha = 0.01.
MIN_TANGENT = 1e-5

#: Nodes and weights of Gauss and Legendre in [-1, 1], by their number.
gauss = functools.cache(np.polynomial.legendre.leggauss)


def half_vector_rule(wi: np.ndarray, *, anisotropic: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return wo (N, M, 3) and weights (N, M): the sum of f(wo) cos_o weights integrates f cos_o.

    wi: (N, 3) unit vectors above the horizon.
    anisotropic: whether f may be. Otherwise nodes lie on one side of the plane of incidence, and
        the integrand must be the same on the other. There are four times as many nodes for
        anisotropic ones, twice as dense, because the azimuth changes them.

    The integration variable is the half vector, logarithmic in tan theta_h, which resolves narrow
    and wide lobes. With wi = (s, 0, c) and h at (theta, phi), the cosine of wo is
    s cos(phi) sin(2 theta) + c cos(2 theta). The range of theta ends at its zero, so that all nodes
    are above the horizon and no discontinuity is integrated. The Jacobian of reflection is 4 wi.h.
    """
    wi = np.asarray(wi, np.float64)
    c = wi[:, 2, None, None]
    s = np.hypot(wi[:, 0], wi[:, 1])[:, None, None]
    nodes, weights = gauss(AZIMUTH_NODES * (1 + anisotropic))
    quarter = 0.25 * np.pi * (nodes + 1.0)
    phi = np.concatenate([quarter, np.pi - quarter])[:, None]
    phi_weight = np.tile(2.0 * 0.25 * np.pi * weights, 2)[:, None]  # both sides of the plane
    if anisotropic:
        phi, phi_weight = np.concatenate([phi, -phi]), np.tile(0.5 * phi_weight, (2, 1))
    nodes, weights = gauss(POLAR_NODES)
    end = 0.5 * (0.5 * np.pi + np.arctan2(s * np.cos(phi), c))
    first = np.log(MIN_TANGENT)
    span = np.maximum(np.log(np.tan(end)) - first, 0.0)
    tangent = np.exp(first + span * 0.5 * (nodes + 1.0))
    cos_h = 1.0 / np.sqrt(1.0 + tangent * tangent)
    sin_h = tangent * cos_h
    h = np.stack(np.broadcast_arrays(sin_h * np.cos(phi), sin_h * np.sin(phi), cos_h), axis=-1)
    dot = s * h[..., 0] + c * h[..., 2]
    wo = 2.0 * dot[..., None] * h
    wo[..., 0] -= s
    wo[..., 2] -= c
    # d(omega_h) = sin theta d(theta) d(phi), and d(theta) = sin cos d(ln tan theta)
    weight = 4.0 * dot * sin_h * sin_h * cos_h * (0.5 * span * weights) * phi_weight
    azimuth = np.arctan2(wi[:, 1], wi[:, 0])[:, None]
    return turned(wo.reshape(len(wi), -1, 3), azimuth), weight.reshape(len(wi), -1)
