"""Fresnel reflectance of unpolarised light."""

import drjit as dr


def dielectric(cos_i, eta):
    """Reflectance of a smooth dielectric boundary and the refracted cosine.

    Args:
        cos_i: cosine of the incident angle, in [0, 1].
        eta: index of the far side relative to the near side, > 0.

    Returns:
        (F, cos_t): reflectance in [0, 1] and the cosine (>= 0) of the refracted angle;
        F = 1 and cos_t = 0 under total internal reflection. F = 0 at an index of 1.
    """
    inv_eta = 1 / eta
    cos_t2 = 1 - (1 - cos_i * cos_i) * inv_eta * inv_eta
    cos_t = dr.select(eta == 1, cos_i, dr.safe_sqrt(cos_t2))  # to the last digit
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


def exact(cosine, eta, k, xp):
    """Reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1), without loss of digits.

    eta < 1 reflects totally beyond the critical angle. k None is a dielectric, whose formula is
    shorter and keeps its digits for eta near 1. Terms of 1e-12 replace the branches for 0 / 0.
    """
    named = xp.named
    cos2 = named("cos2", cosine * cosine)
    sin2 = named("sin2", 1.0 - cos2)
    if k is None:
        root = named("root", xp.sqrt(xp.positive((eta - 1.0) * (eta + 1.0) + cos2)))
        across = named("second", root * cosine)
        n2, d2 = named("third", across - sin2), named("fourth", across + sin2)
        ratio = named("parallel", (root - cosine) / ((root + cosine) * d2 + 1e-12))
        return 0.5 * (ratio * ratio) * (d2 * d2 + n2 * n2)
    # eta^2 - k^2 - sin2 without loss of digits at grazing angles
    difference = named("difference", ((eta - 1.0) * (eta + 1.0) - k * k) + cos2)
    size = named("size", xp.sqrt(difference * difference + 4.0 * (eta * eta) * (k * k)))
    a = named("root", xp.sqrt(0.5 * xp.positive(size + difference)))
    first, second = named("first", size + cos2), named("second", 2.0 * a * cosine)
    perpendicular = named("across", (first - second) / (first + second))
    third, fourth = named("third", cos2 * size + sin2 * sin2), named("fourth", second * sin2)
    ratio = named("parallel", (third - fourth + 1e-12) / (third + fourth + 1e-12))
    return 0.5 * perpendicular * (1.0 + ratio)
