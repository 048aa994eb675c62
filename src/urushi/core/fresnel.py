"""Fresnel reflectance of unpolarised light."""

import drjit as dr


def dielectric(cos_i, eta):
    """Reflectance of a smooth dielectric boundary and the refracted cosine.

    Args:
        cos_i: cosine of the incident angle, in [0, 1].
        eta: index of the far side relative to the near side, > 0.

    Returns:
        (F, cos_t): reflectance in [0, 1] and the cosine (>= 0) of the refracted angle;
        F = 1 and cos_t = 0 under total internal reflection.
    """
    inv_eta = 1 / eta
    cos_t2 = 1 - (1 - cos_i * cos_i) * inv_eta * inv_eta
    cos_t = dr.safe_sqrt(cos_t2)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return dr.select(cos_t2 > 0, reflectance, 1), cos_t


def schlick(cos_i, r0):
    """Schlick's 1994 approximation, r0 + (1 - r0)(1 - cos)^5; `r0` may be a colour."""
    m = dr.clip(1 - cos_i, 0, 1)
    m2 = m * m
    return r0 + (1 - r0) * (m2 * m2 * m)


def conductor(cos_i, eta, k):
    """Reflectance of a smooth conductor of complex index eta - i k, relative to air.

    Source: PBRT v3, 8.2.1 (from Lagarde 2013); exact for a non-absorbing incident medium.
    """
    cos2 = cos_i * cos_i
    sin2 = 1 - cos2
    eta2, k2 = eta * eta, k * k
    t0 = eta2 - k2 - sin2
    a2_plus_b2 = dr.safe_sqrt(t0 * t0 + 4 * eta2 * k2)
    t1 = a2_plus_b2 + cos2
    a = dr.safe_sqrt(0.5 * (a2_plus_b2 + t0))
    t2 = 2 * a * cos_i
    perpendicular = (t1 - t2) / (t1 + t2)
    t3 = cos2 * a2_plus_b2 + sin2 * sin2
    t4 = t2 * sin2
    # 0 / 0 at normal incidence on an index of zero, where both polarisations reflect alike.
    ratio = dr.select(t3 + t4 > 0, (t3 - t4) / (t3 + t4), 1)
    parallel = perpendicular * ratio
    return 0.5 * (parallel + perpendicular)
