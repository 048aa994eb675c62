"""Thin walls that scatter light to both sides: leaves and paper."""

import drjit as dr
import mitsuba as mi

from urushi.core import microfacet
from urushi.core.mixture import Mixture
from urushi.mitsuba.plugins.coats import raised
from urushi.openpbr_surface import model
from urushi.openpbr_surface.bsdfs import MIN_SHARE
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.transmission.sides import TwoSided, above_surface


def define(proposal_bsdf: type) -> type:
    """Make the class in the current variant; see `define_proposal_bsdf`."""

    class Sheet(proposal_bsdf):
        """A thin wall of a medium that scatters light to both sides, below interfaces (3.2.3)."""

        def __init__(self, inputs: Inputs):
            super().__init__(mi.Properties("openpbr_sheet"))
            self._inputs, self._base = inputs, model.Base(inputs, False, False)
            self._transmit()

        def _vertex(self, si, active):
            inputs, vertex = self._inputs, self._base.vertex(si, active)
            color = inputs.color("subsurface_color", si, active)
            forward = 0.5 + 0.5 * inputs.number("subsurface_scatter_anisotropy", si, active)
            near, far = color * (1 - forward), color * forward
            return vertex._replace(color=near), vertex._replace(color=far), forward

        def _f(self, vertex, ctx, si, wo, active):
            near, far, _ = vertex
            through, wo, si = si.wi.z * wo.z < 0, raised(wo), above_surface(si)
            passed = self._base.diffuse(far, si, wo, active)
            lobe, cosine = microfacet.reflection_lobe(si.wi, wo, near.widths)
            reflected = self._base.glossy_diffuse(near, lobe, dr.abs(cosine), si, wo, active)
            return dr.select(through, passed, reflected)

        def _proposal(self, vertex, si, active):
            near, _, forward = vertex
            reflected = self._base.reflected(raised(si.wi), near)
            through = dr.clip((1 - reflected) * forward, 0, 1 - MIN_SHARE)
            share = dr.clip(reflected / (1 - through), MIN_SHARE, 1 - MIN_SHARE)
            return TwoSided(Mixture([share, 1 - share], [near.widths]), through)

        def traverse(self, callback):
            names = "subsurface_color", "subsurface_scatter_anisotropy", "base_diffuse_roughness"
            more = "specular_roughness", "specular_ior", "specular_color"
            self._inputs.traverse(callback, (*names, *more))

        def to_string(self):
            return "OpenPBRSheet[]"

    return Sheet
