"""A bottom with what measured BRDFs have and microfacet models lack: long tails, retro-reflection.

Its parameters are no physical description; it spans shapes, so that networks trained on it know
those of measured materials.
"""

import dataclasses
from typing import Any

import drjit as dr

from urushi.physics import fresnel, microfacet
from urushi.physics.frame import reflect, square_to_cosine_hemisphere

#: The least share of the samples that is cosine-distributed.
LEAST_COSINE_SHARE = 0.1


@dataclasses.dataclass(frozen=True)
class Lobe:
    """A specular lobe of generalised Trowbridge-Reitz normals with Smith's masking of GGX.

    Attributes:
        weight: factor of the lobe, in [0, 1].
        alpha, gamma: width and exponent, see `microfacet.gtr_d`.
        r0: Schlick's reflectance at normal incidence.
        masking: the width of the GGX distribution whose masking it has.
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
        """BRDF [1/sr], both directions above the horizon and m half way between them."""
        masked = microfacet.smith_g1(wi, self.masking) * microfacet.smith_g1(wo, self.masking)
        reflectance = fresnel.schlick(dr.abs(dr.dot(wi, m)), self.r0)
        return self.weight * reflectance * self.d(m) * masked / (4 * wi.z * wo.z)

    def pdf(self, wi, m):
        """Density [1/sr] of reflecting wi about a normal of density d cos."""
        return self.d(m) * m.z / (4 * dr.abs(dr.dot(wi, m)))


#: A lobe's parameters, in order.
LOBE_PARAMETERS = tuple(field.name for field in dataclasses.fields(Lobe))


class MeasuredLike:
    """A diffuse term with retro-reflection, sheen, and two lobes of their own tails.

    f = diffuse / pi R(cos_i) R(cos_o) + sheen / pi (1 - cos_d)^5 + lobes, where
    R(c) = 1 + (F - 1) (1 - c)^5 with F = 1/2 + 2 roughness cos_d^2 (Burley 2012, section 5.3).
    """

    def __init__(self, diffuse, roughness, sheen, *lobes):
        self._diffuse, self._roughness, self._sheen = diffuse, roughness, sheen
        self._lobes = Lobe(*lobes[:5]), Lobe(*lobes[5:])
        first, second = (lobe.weight for lobe in self._lobes)
        total = first + second + diffuse + 1e-6
        self._shares = tuple((1 - LEAST_COSINE_SHARE) * w / total for w in (first, second))

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
    x = dr.clip(x, 0, 1)
    return dr.square(dr.square(x)) * x
