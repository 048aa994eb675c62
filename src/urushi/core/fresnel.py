"""Fresnel reflectance of unpolarised light.

All functions take a `Namespace` as their last argument, `xp`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.core.namespace import DRJIT, NUMPY, Namespace

#: The cosine at which F82's tint multiplies Schlick's reflectance, about 82 degrees.
EDGE_COSINE = 1 / 7

_EDGE = (1 - EDGE_COSINE) ** 5

#: Gauss-Legendre nodes of the mean over the cosine, and weights of 2 cos dcos: exact where `f82` is
#: a polynomial, and within 0.0013 where it is clamped.
_NODES, _WEIGHTS = (0.5 * x for x in np.polynomial.legendre.leggauss(8))
_NODES = _NODES + 0.5
_WEIGHTS = 2 * _WEIGHTS * _NODES


def dielectric(cos_i: Any, eta: Any, xp: Namespace = DRJIT) -> tuple[Any, Any]:
    """Reflectance of a smooth dielectric boundary and the refracted cosine.

    Args:
        cos_i: cosine of the incident angle, in [0, 1].
        eta: index of the far side relative to the near side, > 0.
        xp: see the module.

    Returns:
        (F, cos_t): reflectance in [0, 1] and the cosine (>= 0) of the refracted angle;
        F = 1 and cos_t = 0 under total internal reflection. F = 0 at an index of 1.
    """
    inv_eta = 1 / eta
    cos_t2 = 1 - (1 - cos_i * cos_i) * inv_eta * inv_eta
    cos_t = xp.safe_sqrt(xp.maximum(cos_t2, 0))
    cos_t = xp.where(eta == 1, cos_i, cos_t)  # to the last digit
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return xp.where(cos_t2 > 0, reflectance, 1), cos_t


def schlick(cos_i: Any, r0: Any, xp: Namespace = DRJIT) -> Any:
    """Schlick's 1994 approximation, r0 + (1 - r0)(1 - cos)^5; `r0` may be a colour."""
    m = xp.clip(1 - cos_i, 0, 1)
    m2 = m * m
    return r0 + (1 - r0) * (m2 * m2 * m)


def f82(cosine: Any, f0: Any, tint: Any, xp: Namespace = NUMPY) -> Any:
    """F82-tint reflectance of a metal: Schlick's term with a dip towards the edge.

    Args:
        cosine: of the angle between the light and the facet, in [0, 1].
        f0: reflectance at normal incidence.
        tint: the fraction of Schlick's term that is left at 82 degrees.
        xp: see the module.

    Returns:
        The reflectance, in [0, 1]. The dip of a dark metal with a dark tint is deeper than
        Schlick's term and is clamped, as in Adobe's openpbr-bsdf.

    Source: Kutz, Hasan and Edmondson 2021, Novel aspects of the Adobe Standard Material.
    """
    away = 1 - cosine
    fifth = away * away * away * away * away
    edge = f0 + (1 - f0) * _EDGE
    dip = cosine * fifth * away * (1 / (EDGE_COSINE * _EDGE * (1 - EDGE_COSINE)))
    value = f0 + (1 - f0) * fifth - dip * edge * (1 - tint)
    return xp.where(value < 0, 0, value)  # unlike a maximum, it has gradients at zero


def f82_mean(f0: Any, tint: Any, xp: Namespace = NUMPY) -> Any:
    """Cosine-weighted mean of `f82` over the hemisphere."""
    return hemisphere_mean(lambda cosine: f82(cosine, f0, tint, xp))


def hemisphere_mean(reflectance: Callable[[float], Any]) -> Any:
    """Cosine-weighted mean of a function of the cosine, 2 times the integral of F cos dcos."""
    nodes = zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True)
    return sum(weight * reflectance(cosine) for cosine, weight in nodes)


def exact(cosine: Any, eta: Any, k: Any, xp: Namespace = DRJIT) -> Any:
    """Reflectance of a smooth surface of complex index eta - i k, without loss of digits.

    k None is a dielectric, whose formula is shorter and keeps its digits for eta near 1; eta < 1
    reflects totally beyond the critical angle. Terms of 1e-12 replace the branches for 0 / 0. All
    terms are squares, so that no rounding makes the reflectance negative.

    Source: PBRT v3, 8.2.1 (from Lagarde 2013); exact for a non-absorbing incident medium.
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
    size = named("size", xp.safe_sqrt(difference * difference + 4.0 * (eta * eta) * (k * k)))
    a = named("root", xp.safe_sqrt(0.5 * xp.positive(size + difference)))
    b2 = named("imaginary2", 0.5 * xp.positive(size - difference))
    less, more = named("less", a - cosine), named("more", a + cosine)
    perpendicular = named("across", (less * less + b2) / (more * more + b2))
    product, far = named("product", a * cosine), named("far", b2 * cos2 + 1e-12)
    n, d = named("third", product - sin2), named("fourth", product + sin2)
    ratio = named("parallel", (n * n + far) / (d * d + far))
    return 0.5 * perpendicular * (1.0 + ratio)
