"""A GGX reflector; its subclasses, conductors and dielectrics, give the Fresnel term."""

from typing import Any, ClassVar

import drjit as dr

from urushi.core import microfacet
from urushi.core.frame import reflect
from urushi.walk.bottoms.bottom import Family


class Microfacet(Family):
    """A GGX reflector of one width or two `Widths`."""

    bare: ClassVar[bool] = True

    def __init__(self, alpha: Any) -> None:
        self.alpha = alpha

    def reflectance(self, cos_m: Any) -> Any:
        """The Fresnel reflectance, a float or colour, at the cosine wi.m >= 0."""
        raise NotImplementedError

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        lobe, cos_m = microfacet.reflection_lobe(wi, wo, self.alpha)
        pdf = lobe * wo.z / microfacet.smith_g1(wo, self.alpha)
        return lobe * self.reflectance(dr.abs(cos_m)), dr.select(lobe > 0, pdf, 0)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        m = microfacet.sample_visible_normal(wi, self.alpha, u1, u2)
        cos_m = dr.dot(wi, m)
        wo = reflect(wi, m)
        g1 = microfacet.smith_g1(wo, self.alpha)
        pdf = microfacet.visible_normal_pdf(wi, m, self.alpha) / (4 * cos_m)
        valid = wo.z > 0
        weight = self.reflectance(dr.abs(cos_m)) * dr.select(valid, g1, 0)
        return wo, weight, dr.select(valid, pdf, 0)
