"""A diffuse term with a GGX and a Beckmann lobe; training draws it, nothing describes it."""

import drjit as dr
import numpy as np

from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect, square_to_cosine_hemisphere
from urushi.walk.bottoms.bottom import Family, draw_alpha


class Mixture(Family, kind="mixture"):
    """A diffuse term, a GGX lobe and a Beckmann lobe: plastics, paints and the like.

    f = diffuse / pi + ggx_weight GGX(ggx_alpha, ggx_r0) + beckmann_weight Beckmann(...), each lobe
    with Schlick's Fresnel term and one width or two `Widths`. Both lobes are sampled by visible
    normals of GGX, whose tails are longer than Beckmann's.
    """

    parameters = (
        *("diffuse", "ggx_weight", "ggx_alpha", "ggx_r0"),
        *("beckmann_weight", "beckmann_alpha", "beckmann_r0"),
    )

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
        m = dr.normalize(wi + wo)
        g = microfacet.beckmann_g1(wi, alpha) * microfacet.beckmann_g1(wo, alpha)
        lobe = microfacet.beckmann_d(m, alpha) * g / (4 * wi.z * wo.z)
        f += weight * lobe * fresnel.schlick(dr.abs(cos_m), r0)
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

    @staticmethod
    def draw(rng, n, draw_eta):
        """Weights add up to at most one.

        A quarter are Beckmann conductors alone. A quarter are plastics of either distribution: a
        lobe of low R0 = U(0.02, 0.1) over a diffuse term. In the other half all three weights are
        Dirichlet(1/2) times U(0, 1)^(1/3), so that one or two of them often dominate.
        """
        kind = rng.integers(4, size=n)
        weights = rng.dirichlet((0.5, 0.5, 0.5), n) * rng.uniform(0, 1, (n, 1)) ** (1 / 3)
        r0 = rng.uniform(0.0, 1.0, (n, 2))
        which = rng.integers(2, size=n)
        plastic = np.stack([rng.uniform(0, 0.9, n), which == 0, which == 1], axis=-1)
        weights = np.where((kind == 0)[:, None], [0.0, 0.0, 1.0], weights)
        weights = np.where((kind == 1)[:, None], plastic, weights)
        r0 = np.where((kind == 1)[:, None], rng.uniform(0.02, 0.1, (n, 1)), r0)
        return {
            "diffuse": weights[:, 0],
            "ggx_weight": weights[:, 1],
            "ggx_alpha": draw_alpha(rng, n),
            "ggx_r0": r0[:, 0],
            "beckmann_weight": weights[:, 2],
            "beckmann_alpha": draw_alpha(rng, n),
            "beckmann_r0": r0[:, 1],
        }


def _visible_reflection_pdf(wi, wo, alpha):
    """Density of reflecting wi about a visible GGX normal, at wo above the horizon."""
    m = dr.normalize(wi + wo)
    return microfacet.smith_g1(wi, alpha) * microfacet.ggx_d(m, alpha) / (4 * wi.z)
