"""BRDFs of bottoms for the random walk: density, sampling and values as Dr.Jit arrays.

`Bottom` is the protocol. `f` is without cosine [1/sr]. Values are Dr.Jit floats or colours; the
parameters of a bottom may vary per lane.
"""

import dataclasses
from typing import Any, Protocol

import drjit as dr

from urushi.checks import Widths
from urushi.core import fresnel, microfacet
from urushi.core.frame import reflect, square_to_cosine_hemisphere

#: Least share of cosine-distributed samples of `MeasuredLike`.
MIN_COSINE_SHARE = 0.1


class Bottom(Protocol):
    """The BRDF under the lowest medium, as the random walk uses it."""

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon."""

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        """Draw wo by three uniform numbers; returns (wo, weight, pdf).

        weight = f cos / pdf; it is 0 if the sample fails.
        """


class Microfacet:
    """A GGX reflector of one width or two `Widths`.

    `fresnel_term` maps the cosine wi.m to a reflectance, a float or colour.
    """

    def __init__(self, alpha, fresnel_term):
        self.alpha = alpha
        self.fresnel_term = fresnel_term

    def f_pdf(self, wi, wo):
        lobe, cos_m = microfacet.reflection_lobe(wi, wo, self.alpha)
        pdf = lobe * wo.z / microfacet.smith_g1(wo, self.alpha)
        return lobe * self.fresnel_term(dr.abs(cos_m)), dr.select(lobe > 0, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        m = microfacet.sample_visible_normal(wi, self.alpha, u1, u2)
        cos_m = dr.dot(wi, m)
        wo = reflect(wi, m)
        g1 = microfacet.smith_g1(wo, self.alpha)
        pdf = microfacet.visible_normal_pdf(wi, m, self.alpha) / (4 * cos_m)
        valid = wo.z > 0
        weight = self.fresnel_term(dr.abs(cos_m)) * dr.select(valid, g1, 0)
        return wo, weight, dr.select(valid, pdf, 0)


class Lambertian:
    """Ideal diffuse reflection of the given reflectance."""

    def __init__(self, reflectance):
        self.reflectance = reflectance

    def f_pdf(self, wi, wo):
        valid = (wi.z > 0) & (wo.z > 0)
        return (
            self.reflectance * dr.select(valid, dr.inv_pi, 0),
            dr.select(valid, wo.z * dr.inv_pi, 0),
        )

    def sample(self, wi, u0, u1, u2):
        wo = square_to_cosine_hemisphere(type(wi), u1, u2)
        return wo, self.reflectance, wo.z * dr.inv_pi


class MixtureBottom:
    """A diffuse term, a GGX lobe and a Beckmann lobe: plastics, paints and the like.

    f = diffuse / pi + ggx_weight GGX(ggx_alpha, ggx_r0) + beckmann_weight Beckmann(...), each lobe
    with Schlick's Fresnel term and one width or two `Widths`. Both lobes are sampled by visible
    normals of GGX, whose tails are longer than Beckmann's.
    """

    def __init__(
        self, diffuse, ggx_weight, ggx_alpha, ggx_r0, beckmann_weight, beckmann_alpha, beckmann_r0
    ):
        self._diffuse = diffuse
        self._ggx = ggx_weight, ggx_alpha, ggx_r0
        self._beckmann = beckmann_weight, beckmann_alpha, beckmann_r0
        total = diffuse + ggx_weight + beckmann_weight + 1e-6
        self._share_ggx = ggx_weight / total
        self._share_beckmann = beckmann_weight / total

    def f_pdf(self, wi, wo):
        weight, alpha, r0 = self._ggx
        lobe, cos_m = microfacet.reflection_lobe(wi, wo, alpha)
        f = weight * lobe * fresnel.schlick(dr.abs(cos_m), r0)
        pdf = self._share_ggx * _visible_reflection_pdf(wi, wo, alpha)
        weight, alpha, r0 = self._beckmann
        f += weight * _beckmann_lobe(wi, wo, alpha) * fresnel.schlick(dr.abs(cos_m), r0)
        pdf += self._share_beckmann * _visible_reflection_pdf(wi, wo, alpha)
        f += self._diffuse * dr.inv_pi
        pdf += (1 - self._share_ggx - self._share_beckmann) * wo.z * dr.inv_pi
        valid = (wi.z > 0) & (wo.z > 0)
        return dr.select(valid, f, 0), dr.select(valid, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        is_ggx = u0 < self._share_ggx
        is_lobe = u0 < self._share_ggx + self._share_beckmann
        alpha = dr.select(is_ggx, self._ggx[1], self._beckmann[1])
        m = microfacet.sample_visible_normal(wi, alpha, u1, u2)
        cosine = square_to_cosine_hemisphere(type(wi), u1, u2)
        wo = dr.select(is_lobe, reflect(wi, m), cosine)
        f, pdf = self.f_pdf(wi, wo)
        return wo, dr.select(pdf > 0, f * wo.z / pdf, 0), pdf


def _visible_reflection_pdf(wi, wo, alpha):
    """Density of reflecting wi about a visible GGX normal, at wo above the horizon."""
    m = dr.normalize(wi + wo)
    return microfacet.smith_g1(wi, alpha) * microfacet.ggx_d(m, alpha) / (4 * wi.z)


def _beckmann_lobe(wi, wo, alpha):
    """The Beckmann reflection BRDF for Fresnel reflectance 1 [1/sr]."""
    m = dr.normalize(wi + wo)
    g = microfacet.beckmann_g1(wi, alpha) * microfacet.beckmann_g1(wo, alpha)
    return microfacet.beckmann_d(m, alpha) * g / (4 * wi.z * wo.z)


def schlick_conductor(alpha, r0):
    """GGX conductor with Schlick's Fresnel term."""
    return Microfacet(alpha, lambda cos_m: fresnel.schlick(cos_m, r0))


def conductor(alpha, eta, k):
    """GGX conductor with the exact Fresnel term of a complex index."""
    return Microfacet(alpha, lambda cos_m: fresnel.conductor(cos_m, eta, k))


def dielectric_reflector(alpha, eta):
    """The reflection of a rough dielectric; the transmitted light is lost."""
    return Microfacet(alpha, lambda cos_m: fresnel.dielectric(cos_m, eta)[0])


def anisotropic(reflector):
    """The factory of an anisotropic reflector, of alpha_u, alpha_v, and `reflector`'s others."""
    return lambda alpha_u, alpha_v, *others: reflector(Widths(alpha_u, alpha_v), *others)


def anisotropic_mixture(diffuse, *lobes):
    """`MixtureBottom` of two widths a lobe: weight, alpha_u, alpha_v and R0 of GGX, of Beckmann."""
    ggx, beckmann = (
        (weight, Widths(alpha_u, alpha_v), r0)
        for weight, alpha_u, alpha_v, r0 in (lobes[:4], lobes[4:])
    )
    return MixtureBottom(diffuse, *ggx, *beckmann)


@dataclasses.dataclass(frozen=True)
class Lobe:
    """A specular lobe with generalised Trowbridge-Reitz normals and the Smith masking of GGX.

    Attributes:
        weight: factor of the lobe, in [0, 1].
        alpha, gamma: width and exponent, see `microfacet.gtr_d`.
        r0: Schlick's reflectance at normal incidence.
        masking: GGX width for the masking.
    """

    weight: Any
    alpha: Any
    gamma: Any
    r0: Any
    masking: Any

    def d(self, m):
        """The distribution of normals [1/sr]."""
        return microfacet.gtr_d(m, self.alpha, self.gamma)

    def f(self, wi, wo, m):
        """BRDF [1/sr] for directions above the horizon; m is their normalised half vector."""
        masked = microfacet.smith_g1(wi, self.masking) * microfacet.smith_g1(wo, self.masking)
        reflectance = fresnel.schlick(dr.abs(dr.dot(wi, m)), self.r0)
        return self.weight * reflectance * self.d(m) * masked / (4 * wi.z * wo.z)

    def pdf(self, wi, m):
        """Density [1/sr] of reflecting wi about a normal of density d cos."""
        return self.d(m) * m.z / (4 * dr.abs(dr.dot(wi, m)))


#: Names of a lobe's parameters, in order.
LOBE_PARAMETERS = tuple(field.name for field in dataclasses.fields(Lobe))


class MeasuredLike:
    """A BRDF with features of measured ones: retro-reflection, sheen, and two long-tailed lobes.

    f = diffuse / pi R(cos_i) R(cos_o) + sheen / pi (1 - cos_d)^5 + lobes, where
    R(c) = 1 + (F - 1) (1 - c)^5 with F = 1/2 + 2 roughness cos_d^2 (Burley 2012, section 5.3).
    The parameters span shapes for training; they are no physical description.
    """

    def __init__(self, diffuse, roughness, sheen, *lobes):
        self._diffuse, self._roughness, self._sheen = diffuse, roughness, sheen
        self._lobes = Lobe(*lobes[:5]), Lobe(*lobes[5:])
        first, second = (lobe.weight for lobe in self._lobes)
        total = first + second + diffuse + 1e-6
        self._shares = tuple((1 - MIN_COSINE_SHARE) * w / total for w in (first, second))

    def f_pdf(self, wi, wo):
        m = dr.normalize(wi + wo)
        cos_d = dr.abs(dr.dot(wi, m))
        grazing = 0.5 + 2 * self._roughness * dr.square(cos_d) - 1
        retro = dr.fma(grazing, _fifth(1 - wi.z), 1) * dr.fma(grazing, _fifth(1 - wo.z), 1)
        f = dr.inv_pi * (self._diffuse * retro + self._sheen * _fifth(1 - cos_d))
        pdf = (1 - sum(self._shares)) * wo.z * dr.inv_pi
        for share, lobe in zip(self._shares, self._lobes, strict=True):
            f += lobe.f(wi, wo, m)
            pdf += share * lobe.pdf(wi, m)
        valid = (wi.z > 0) & (wo.z > 0)
        return dr.select(valid, f, 0), dr.select(valid, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        first, second = self._lobes
        is_first = u0 < self._shares[0]
        alpha = dr.select(is_first, first.alpha, second.alpha)
        gamma = dr.select(is_first, first.gamma, second.gamma)
        m = microfacet.sample_gtr(type(wi), alpha, gamma, u1, u2)
        cosine = square_to_cosine_hemisphere(type(wi), u1, u2)
        wo = dr.select(u0 < sum(self._shares), reflect(wi, m), cosine)
        f, pdf = self.f_pdf(wi, wo)
        return wo, dr.select(pdf > 0, f * wo.z / pdf, 0), pdf


def _fifth(x):
    """The fifth power of x, clamped to [0, 1]."""
    x = dr.clip(x, 0, 1)
    return dr.square(dr.square(x)) * x
