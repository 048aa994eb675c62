"""The local shading frame: z is the normal, directions are unit 3-vectors of any Dr.Jit backend."""

import drjit as dr


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


def from_cosine(axis, cos_theta, phi):
    """The unit vector at angle acos(`cos_theta`) from `axis` and azimuth `phi` about it."""
    sin_theta = dr.safe_sqrt(1 - cos_theta * cos_theta)
    sin_phi, cos_phi = dr.sincos(phi)
    s, t = coordinate_system(axis)
    return dr.normalize(s * (sin_theta * cos_phi) + t * (sin_theta * sin_phi) + axis * cos_theta)


def square_to_cosine_hemisphere(vector, u1, u2):
    """Cosine-distributed direction on the upper hemisphere, of type `vector`; density cos / pi."""
    radius, phi = dr.sqrt(u1), 2 * dr.pi * u2
    sin_phi, cos_phi = dr.sincos(phi)
    return vector(radius * cos_phi, radius * sin_phi, dr.safe_sqrt(1 - u1))
