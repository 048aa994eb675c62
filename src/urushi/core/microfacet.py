"""Microfacet distributions with separable Smith masking, G = G1(wi) G1(wo).

All interfaces are GGX, isotropic or anisotropic: `alpha` is one width, or the two `Widths` along x
and y (Heitz 2014, section 5.4). Two equal widths agree with one up to rounding. The other
distributions are used by bottoms only, Beckmann's with one width or two.
"""

import math

import drjit as dr

from urushi.checks import Widths
from urushi.core.namespace import DRJIT, Components


def ggx_d(m, alpha):
    """Normal distribution D(m) [1/sr] of a unit facet normal (Walter et al. 2007, eq. 33).

    With two widths, Heitz 2014, eq. 85. Written with m.x^2 + m.y^2 instead of 1 - cos^2, which
    keeps float32 exact for small alpha.
    """
    alpha2 = product(alpha)
    denominator = dr.fma(alpha2 * m.z, m.z, squeezed_sine2(m, alpha))
    d = alpha2 / (dr.pi * denominator * denominator)
    return dr.select(m.z > 0, d, 0)


def smith_g1(w, alpha):
    """Smith masking of direction `w` on either side (Walter et al. 2007, eq. 34).

    With two widths, their mean square towards the azimuth of `w` (Heitz 2014, eq. 80).
    """
    cos2 = w.z * w.z
    tan2 = stretched_sine2(w, alpha) / cos2
    return dr.select(cos2 > 0, 2 / (1 + dr.sqrt(1 + product(alpha) * tan2)), 0)


def visible_normal_pdf(w, m, alpha):
    """Density [1/sr] of `sample_visible_normal` at facet normal `m`; w.z > 0."""
    return smith_g1(w, alpha) * ggx_d(m, alpha) * dr.maximum(dr.dot(w, m), 0) / w.z


def sample_visible_normal(w, alpha, u1, u2):
    """Sample a unit facet normal visible from `w` (w.z > 0), uniformly on a spherical cap."""
    w = stretched(w, alpha)
    m = cap_normal(w, alpha, dr.fma(1 - u2, 1 + w.z, -w.z), u1)
    return dr.normalize(type(m)(m.x, m.y, dr.maximum(m.z, 0)))


def stretched(w, alpha, xp=DRJIT):
    """The direction `w` in the space where the GGX surface of width `alpha` is a hemisphere."""
    u, v = pair(alpha)
    return xp.normalized(type(w)(u * w.x, v * w.y, w.z))


def cap_normal(w, alpha, z, u, xp=DRJIT):
    """The facet normal of a point of the spherical cap seen from the `stretched` direction `w`.

    The point has the height z in [-w.z, 1] and the azimuth 2 pi u. The normal has any length.
    Source: Dupuy & Benyoub 2023, listing 1.
    """
    sin_phi, cos_phi = xp.sincos(xp.named("phi", (2 * math.pi) * u))
    sin_theta = xp.named("radius", xp.sqrt(xp.positive(1 - z * z)))
    along, across = pair(alpha)
    x, y = along * (sin_theta * cos_phi + w.x), across * (sin_theta * sin_phi + w.y)
    return type(w)(x, y, z + w.z)


def visible_normal(alpha, wi, u1, u2, xp=DRJIT):
    """A facet normal, of any length, that is visible from wi: uniform numbers choose it."""
    w = stretched(wi, alpha, xp)
    height = xp.named("height", (1.0 - u2) * (1.0 + w.z) - w.z)
    h = cap_normal(w, alpha, height, u1, xp)
    return type(h)(*(xp.named(f"facet_{axis}", getattr(h, axis)) for axis in "xyz"))


def pair(alpha):
    """The GGX widths along x and y."""
    return (alpha.u, alpha.v) if isinstance(alpha, Widths) else (alpha, alpha)


def of_widths(function, *values):
    """A function of numbers, for each of two widths if one of the values is `Widths`."""
    if not any(isinstance(value, Widths) for value in values):
        return function(*values)
    return Widths(*(function(*axis) for axis in zip(*map(pair, values), strict=True)))


def product(alpha):
    """The product of the two GGX widths, which is the square of one."""
    u, v = pair(alpha)
    return u * v


def stretched_sine2(w, alpha):
    """The squared sine (u^2 w.x^2 + v^2 w.y^2) / (u v); w.x^2 + w.y^2 for one width.

    `w` is a vector of any length.
    """
    x2, y2 = w.x * w.x, w.y * w.y
    if isinstance(alpha, Widths):
        x2, y2 = x2 * (alpha.u / alpha.v), y2 * (alpha.v / alpha.u)
    return x2 + y2


def squeezed_sine2(m, alpha):
    """The squared sine (m.x^2 / u^2 + m.y^2 / v^2) u v; m.x^2 + m.y^2 for one width."""
    crossed = Widths(alpha.v, alpha.u) if isinstance(alpha, Widths) else alpha
    return stretched_sine2(m, crossed)


def reflection_lobe(wi, wo, alpha):
    """The microfacet reflection BRDF for Fresnel reflectance 1 [1/sr], and the cosine wi.m.

    Multiply it by the Fresnel term at that cosine. It is zero below the horizon.
    """
    h = half_vector(wi, wo, DRJIT)
    # Clamped, so that derivatives are finite below the horizon too.
    i, o = (Components(w.x, w.y, DRJIT.positive(w.z)) for w in (wi, wo))
    f = lobe_shape(alpha, i, o, h, DRJIT)
    return dr.select((wi.z > 0) & (wo.z > 0), f, 0), facet_cosine(h, DRJIT)


def lobe_shape(alpha, wi, wo, h, xp):
    """The lobe D G / (4 cos_i cos_o) [1/sr] for reflectance 1, of directions above the horizon.

    Walter et al. 2007, eqs. 20, 33 and 34; with two widths Heitz 2014, eqs. 80 and 85. Written
    without the cosines in the denominator, and with h = wi + wo of any length. Exchanging wi and wo
    gives the same bits.
    """
    named = xp.named
    x2, y2 = h.x * h.x, h.y * h.y
    across, z2 = named("half_xy2", x2 + y2), named("half_z2", h.z * h.z)
    if isinstance(alpha, Widths):
        alpha2, u_v, v_u = product_and_quotients(alpha, xp)
        squeezed = x2 * v_u + y2 * u_v

        def root2(w):
            return alpha2 * ((w.x * w.x) * u_v + (w.y * w.y) * v_u) + w.z * w.z

    else:
        alpha2, squeezed = named("alpha2", alpha * alpha), across
        rest = named("remaining", 1.0 - alpha2)

        def root2(w):
            return alpha2 + rest * (w.z * w.z)

    ratio = named("ratio", (across + z2) / (squeezed + alpha2 * z2 + 1e-18))
    # Two names: a product of sums is the same with wi and wo exchanged, whatever is contracted.
    masking_i = named("masking_i", wi.z + xp.sqrt(root2(wi)))
    masking_o = named("masking_o", wo.z + xp.sqrt(root2(wo)))
    return named("lobe_shape", (alpha2 / math.pi) * (ratio * ratio) / (masking_i * masking_o))


def product_and_quotients(alpha, xp):
    """The product of two GGX widths, and the quotients u / v and v / u."""
    return (
        xp.named("alpha2", alpha.u * alpha.v),
        xp.named("u_over_v", alpha.u / alpha.v),
        xp.named("v_over_u", alpha.v / alpha.u),
    )


def half_vector(wi, wo, xp):
    """The sum of two directions, in the direction of the half vector."""
    sums = (wi.x + wo.x, wi.y + wo.y, wi.z + wo.z)
    return Components(*(xp.named(f"half_{axis}", s) for axis, s in zip("xyz", sums, strict=True)))


def facet_cosine(h, xp):
    """The cosine between either direction and their half vector, from their sum h."""
    return xp.named("cos_facet", xp.minimum(0.5 * xp.sqrt(h.x * h.x + h.y * h.y + h.z * h.z), 1.0))


def beckmann_d(m, alpha):
    """Beckmann's normal distribution D(m) [1/sr] (Walter et al. 2007, eq. 25)."""
    alpha2 = product(alpha)
    cos2 = m.z * m.z
    d = dr.exp(-squeezed_sine2(m, alpha) / (alpha2 * cos2)) / (dr.pi * alpha2 * cos2 * cos2)
    return dr.select(m.z > 0, d, 0)


def beckmann_g1(w, alpha):
    """Smith masking for Beckmann's distribution (Walter et al. 2007, section 5.2, rational)."""
    a = dr.abs(w.z) / (dr.sqrt(product(alpha)) * dr.sqrt(stretched_sine2(w, alpha)))
    fit = a * (3.535 + 2.181 * a) / (1 + a * (2.276 + 2.577 * a))
    return dr.select(a >= 1.6, 1, fit)


def gtr_d(m, alpha, gamma):
    """Generalised Trowbridge-Reitz distribution D(m) [1/sr] (Burley 2012, appendix B.2).

    D is proportional to (alpha^2 cos^2 + sin^2)^-gamma and normalised, the integral of D cos being
    one; alpha in (0, 1). gamma = 2 is GGX; a lower gamma (not 1) has longer tails.
    """
    alpha2 = alpha * alpha
    base = dr.fma(alpha2 * m.z, m.z, m.x * m.x + m.y * m.y)
    norm = (gamma - 1) * (1 - alpha2) / (dr.pi * (dr.power(alpha2, 1 - gamma) - 1))
    return dr.select(m.z > 0, norm * dr.power(base, -gamma), 0)


def sample_gtr(vector, alpha, gamma, u1, u2):
    """Sample a facet normal of type `vector` with the density `gtr_d` times its cosine."""
    alpha2 = alpha * alpha
    highest = dr.power(alpha2, 1 - gamma)
    base = dr.power(dr.fma(u2, highest - 1, 1), 1 / (1 - gamma))
    sin2 = dr.clip((base - alpha2) / (1 - alpha2), 0, 1)
    sin_phi, cos_phi = dr.sincos(2 * dr.pi * u1)
    sin_theta = dr.sqrt(sin2)
    return vector(sin_theta * cos_phi, sin_theta * sin_phi, dr.sqrt(1 - sin2))
