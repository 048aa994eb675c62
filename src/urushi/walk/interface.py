"""The rough dielectric interface: a GGX microfacet surface between two media (Walter et al. 2007).

Functions take directions in a frame whose +z side holds `wi` (callers flip z for light from
below), `alpha`, one GGX width or two `Widths`, and `eta`, the index of the far side relative to
wi's side. Transmission is in *flux* convention: the integral of f |cos| over outgoing directions is
the transmitted fraction of power, with no 1/eta^2 scaling of radiance, so that a stack seen from
outside is reciprocal.

An index of 1 is no interface: light passes straight whatever the width. `sample_transmission` and
`sample` then give the opposite of wi with weight 1; functions of two directions give 0.
"""

import drjit as dr

from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect, refract


def flip(w):
    """Mirror `w` to the other side of the interface."""
    return type(w)(w.x, w.y, -w.z)


def reflection(wi, wo, alpha, eta):
    """BRDF [1/sr] of the interface for wi, wo on the same side."""
    lobe, cos_m = microfacet.reflection_lobe(wi, wo, alpha)
    reflectance, _ = fresnel.dielectric(dr.abs(cos_m), eta)
    return lobe * reflectance


def transmission(wi, wo, alpha, eta):
    """BTDF [1/sr] from wi (z > 0) to wo (z < 0), and the density of `sample_transmission` there.

    Walter et al. 2007, eqs. 16, 17 and 21.
    """
    m = wi + eta * wo
    m = dr.normalize(dr.select(m.z < 0, -m, m))
    cos_i, cos_o = dr.dot(wi, m), dr.dot(wo, m)
    valid = (wi.z > 0) & (wo.z < 0) & (cos_i > 0) & (cos_o < 0) & (eta != 1)
    reflectance, _ = fresnel.dielectric(dr.maximum(cos_i, 0), eta)
    denominator = cos_i + eta * cos_o
    jacobian = eta * eta * -cos_o / (denominator * denominator)
    pdf = microfacet.visible_normal_pdf(wi, m, alpha) * jacobian
    f = pdf * (1 - reflectance) * microfacet.smith_g1(wo, alpha) / -wo.z
    return dr.select(valid, f, 0), dr.select(valid, pdf, 0)


def sample_reflection(wi, alpha, eta, u1, u2):
    """Sample a reflected direction; returns (wo, weight), weight = f cos / pdf.

    The weight is zero where the reflected direction falls below the horizon.
    """
    m = microfacet.sample_visible_normal(wi, alpha, u1, u2)
    reflectance, _ = fresnel.dielectric(dr.dot(wi, m), eta)
    wo = reflect(wi, m)
    return wo, dr.select(wo.z > 0, reflectance * microfacet.smith_g1(wo, alpha), 0)


def sample_transmission(wi, alpha, eta, u1, u2):
    """Sample a refracted direction; returns (wo, weight), weight = f |cos| / pdf; 0 if it fails."""
    m = microfacet.sample_visible_normal(wi, alpha, u1, u2)
    reflectance, cos_t = fresnel.dielectric(dr.dot(wi, m), eta)
    wo = refract(wi, m, cos_t, eta)
    valid = (wo.z < 0) & (reflectance < 1)
    weight = dr.select(valid, (1 - reflectance) * microfacet.smith_g1(wo, alpha), 0)
    return dr.select(eta == 1, -wi, wo), dr.select(eta == 1, 1, weight)


def sample(wi, alpha, eta, u0, u1, u2):
    """Sample reflection or transmission in proportion to Fresnel; returns (wo, weight, pdf)."""
    m = microfacet.sample_visible_normal(wi, alpha, u1, u2)
    cos_i = dr.dot(wi, m)
    reflectance, cos_t = fresnel.dielectric(cos_i, eta)
    reflected = u0 < reflectance
    wo = dr.select(reflected, reflect(wi, m), refract(wi, m, cos_t, eta))
    cos_o = dr.dot(wo, m)
    denominator = cos_i + eta * cos_o
    jacobian = dr.select(
        reflected,
        reflectance / (4 * cos_i),
        (1 - reflectance) * eta * eta * -cos_o / (denominator * denominator),
    )
    valid = dr.select(reflected, wo.z > 0, wo.z < 0) & (cos_i > 0)
    pdf = microfacet.visible_normal_pdf(wi, m, alpha) * jacobian
    weight = dr.select(valid, microfacet.smith_g1(wo, alpha), 0)
    pdf = dr.select(valid & (eta != 1), pdf, 0)
    return dr.select(eta == 1, -wi, wo), dr.select(eta == 1, 1, weight), pdf


def scatter(wi, wo, alpha, eta):
    """BSDF [1/sr] of both sides and the density of `sample` at wo."""
    f_transmitted, _ = transmission(wi, wo, alpha, eta)
    f = dr.select(wo.z > 0, reflection(wi, wo, alpha, eta), f_transmitted)
    # Sampling visible normals and Fresnel leaves one factor of f |cos| out: the masking of wo.
    return f, dr.select(f > 0, f * dr.abs(wo.z) / microfacet.smith_g1(wo, alpha), 0)
