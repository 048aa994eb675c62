"""Directions about a surface: reflection, frames, rotations, half and difference angles.

z is the normal. Functions of Dr.Jit take unit 3-vectors of any backend, functions of NumPy arrays
(N, 3). Half and difference angles are those of Rusinkiewicz (1998).
"""

import math
from typing import Any

import drjit as dr
import numpy as np

from urushi.core.namespace import DRJIT, Namespace


def reflect(w, m):
    """Mirror direction `w` about the unit normal `m` (both pointing away)."""
    return dr.fma(2 * dr.dot(w, m), m, -w)


def refract(w, m, cos_t, eta):
    """Refract `w` at a facet with normal `m` (w.m > 0) into the medium of relative index `eta`.

    `cos_t` > 0 is the cosine of the refracted direction with -m, from `fresnel.dielectric`.
    Source: Walter et al. 2007, eq. 40.
    """
    inv_eta = 1 / eta
    return dr.fma(dr.fma(dr.dot(w, m), inv_eta, -cos_t), m, -w * inv_eta)


def coordinate_system(n):
    """Two unit tangents that complete `n` to a right-handed basis (Duff et al. 2017)."""
    sign = dr.copysign(type(n.z)(1), n.z)
    a = -1 / (sign + n.z)
    b = n.x * n.y * a
    vector = type(n)
    s = vector(1 + sign * n.x * n.x * a, sign * b, -sign * n.x)
    t = vector(b, sign + n.y * n.y * a, -n.y)
    return s, t


def from_versine(axis, versine, phi):
    """The unit vector at an angle from `axis` of 1 - cos = `versine` and azimuth `phi` about it.

    Small angles would be lost in their cosine.
    """
    sin_theta = dr.safe_sqrt(versine * (2 - versine))
    sin_phi, cos_phi = dr.sincos(phi)
    s, t = coordinate_system(axis)
    return dr.normalize(
        s * (sin_theta * cos_phi) + t * (sin_theta * sin_phi) + axis * (1 - versine)
    )


def square_to_cosine_hemisphere(vector, u1, u2, xp=DRJIT):
    """Cosine-distributed direction on the upper hemisphere, of type `vector`; density cos / pi."""
    radius, phi = xp.sqrt(u1), (2 * math.pi) * u2
    sin_phi, cos_phi = xp.sincos(phi)
    return vector(radius * cos_phi, radius * sin_phi, xp.safe_sqrt(1 - u1))


def rotated(w: np.ndarray, turn: float, mirrored: bool = False) -> np.ndarray:
    """Rotate directions (N, 3) about the normal, and then negate y if `mirrored`; float32 (N, 3).

    turn: the angle as a fraction of a full turn, counter-clockwise.
    """
    rotation = turned(w, np.array(2 * np.pi * turn))
    return (rotation * [1.0, -1.0 if mirrored else 1.0, 1.0]).astype(np.float32)


def half_difference(wi: Any, wo: Any, xp: Namespace) -> tuple[Any, Any, Any]:
    """Return theta_h, theta_d in [0, pi/2] and phi_d in [0, pi] of unit vectors above the horizon.

    The angles are in radians. phi_d is taken modulo pi: exchanging wi and wo adds pi to it, so that
    every function of these angles is reciprocal, here bit for bit. phi_d is 0 if it is undefined
    (wi = wo); if h is the normal, it counts from the x axis.
    """
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    dx, dy, dz = wi.x - wo.x, wi.y - wo.y, wi.z - wo.z
    # Arc tangents of lengths: an arc cosine would lose the digits of small angles.
    length, aside = xp.sqrt(x * x + y * y + z * z), xp.safe_sqrt(x * x + y * y)
    theta_d = xp.arctan2(xp.safe_sqrt(dx * dx + dy * dy + dz * dz), length)
    sin_h, cos_h = aside / length, z / length
    # wi - wo in the frame about h with the tangent dh/dtheta and the bitangent dh/dphi.
    at_normal = aside == 0
    safe = xp.where(at_normal, 1.0, aside)
    cos_phi, sin_phi = xp.where(at_normal, 1.0, x / safe), y / safe
    along = cos_h * (cos_phi * dx + sin_phi * dy) - sin_h * dz
    across = cos_phi * dy - sin_phi * dx
    sign = xp.where((across < 0) | ((across == 0) & (along < 0)), -1.0, 1.0)
    phi_d = xp.arctan2(sign * across + 0.0, sign * along + 0.0)  # + 0.0: no negative zeros
    return xp.arctan2(aside, z), theta_d, phi_d


def above_horizon(theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray) -> np.ndarray:
    """Return whether both directions of the angles (broadcast) are above the horizon."""
    # cos theta of the pair = cos h cos d -+ sin h sin d cos phi_d.
    return np.cos(theta_h) * np.cos(theta_d) > np.abs(
        np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d)
    )


def directions_at(
    theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return wi and wo, (N, 3) each, of these angles (N,) [rad]; h lies at the azimuth 0.

    Not all angles belong to pairs above the horizon: see `above_horizon`.
    """
    return _about_half_vector(np.sin(theta_h), np.cos(theta_h), theta_d, phi_d)


def directions_at_tangent(
    tan_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of `directions_at`, given tan(theta_h) (N,) instead of theta_h."""
    cos_h = 1.0 / np.sqrt(1.0 + tan_h * tan_h)
    return _about_half_vector(tan_h * cos_h, cos_h, theta_d, phi_d)


def turned(direction: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Return directions (..., 3) turned about the z axis by angles (...) [rad]."""
    x, y, z = (direction[..., i] for i in range(3))
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    return np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)


def _about_half_vector(
    sin_h: np.ndarray, cos_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The pair at the difference angles about h = (sin_h, 0, cos_h)."""
    along, across = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d)
    up = np.cos(theta_d)
    wi, wo = (
        np.stack([cos_h * x + sin_h * up, y, cos_h * up - sin_h * x], axis=-1)
        for x, y in ((along, across), (-along, -across))
    )
    return wi, wo
