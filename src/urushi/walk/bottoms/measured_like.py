"""A BRDF with features of measured ones; training draws it, nothing describes it."""

import dataclasses
from typing import Any

import drjit as dr
import numpy as np

from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect, square_to_cosine_hemisphere
from urushi.walk.bottoms.bottom import Family

#: Least share of cosine-distributed samples.
MIN_COSINE_SHARE = 0.1


@dataclasses.dataclass(frozen=True)
class Lobe:
    """A specular lobe with generalised Trowbridge-Reitz normals and the Smith masking of GGX."""

    weight: Any  # factor of the lobe, in [0, 1]
    alpha: Any  # width, see `microfacet.gtr_d`
    gamma: Any  # exponent
    r0: Any  # Schlick's reflectance at normal incidence
    masking: Any  # GGX width for the masking

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


class MeasuredLike(Family, kind="measured_like"):
    """A BRDF with features of measured ones: retro-reflection, sheen, and two long-tailed lobes.

    f = diffuse / pi R(cos_i) R(cos_o) + sheen / pi (1 - cos_d)^5 + lobes, where
    R(c) = 1 + (F - 1) (1 - c)^5 with F = 1/2 + 2 roughness cos_d^2 (Burley 2012, section 5.3).
    The parameters span shapes for training; they are no physical description.
    """

    parameters = (
        *("diffuse", "roughness", "sheen"),
        *(f"{name}_{k}" for k in (1, 2) for name in LOBE_PARAMETERS),
    )

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

    @staticmethod
    def draw(rng, n, draw_eta):
        """Columns of "measured_like" bottoms: a quarter like paints, a quarter like metals.

        Paints have the same R0 = U(0.02, 0.1) in both lobes, and weights of the lobes that add up
        to 1. Metals have a diffuse term below 0.01. The other half has weights Dirichlet(1/2) times
        U(0, 1)^(1/3) and R0 = U(0, 1). The exponents gamma are log-uniform in [0.6, 8] without 0.97
        to 1.03. The least width is 0.004 for gamma = 2. The width of masking is alpha^U(0.4, 1).
        """
        kind = rng.integers(4, size=n)[:, None]
        weights = rng.dirichlet((0.5, 0.5, 0.5), n) * rng.uniform(0, 1, (n, 1)) ** (1 / 3)
        split = rng.uniform(0, 1, (n, 1))
        paint = np.concatenate([rng.uniform(0, 0.9, (n, 1)) ** 2, split, 1 - split], axis=1)
        dark = 0.01 * rng.uniform(0, 1, (n, 1)) ** 2
        brightness = rng.uniform(0.2, 1, (n, 1))
        metal = np.concatenate([dark, split * brightness, (1 - split) * brightness], axis=1)
        weights = np.select([kind == 0, kind == 1], [paint, metal], weights)
        r0 = np.where(kind == 0, rng.uniform(0.02, 0.1, (n, 1)), rng.uniform(0, 1, (n, 2)))
        gamma = np.exp(rng.uniform(np.log(0.6), np.log(8.0), (n, 2)))
        gamma = np.where(np.abs(gamma - 1) < 0.03, 1.03, gamma)
        alpha = rng.uniform(0.004 ** (1 / 3), 0.98 ** (1 / 3), (n, 2)) ** 3
        alpha = np.clip(alpha, 0.004 * np.sqrt(gamma / 2), 0.98)
        masking = alpha ** rng.uniform(0.4, 1.0, (n, 2))
        columns = {
            "diffuse": weights[:, 0],
            "roughness": rng.uniform(0, 1, n),
            "sheen": np.where(rng.integers(2, size=n) == 0, 0.0, rng.uniform(0, 1, n) ** 3),
        }
        for k in (0, 1):
            lobe = (weights[:, 1 + k], alpha[:, k], gamma[:, k], r0[:, k], masking[:, k])
            columns |= {f"{name}_{k + 1}": x for name, x in zip(LOBE_PARAMETERS, lobe, strict=True)}
        return columns


def _fifth(x):
    """The fifth power of x, clamped to [0, 1]."""
    x = dr.clip(x, 0, 1)
    return dr.square(dr.square(x)) * x
