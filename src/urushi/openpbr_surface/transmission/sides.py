"""Surfaces seen from both sides: their frames and proposals."""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.mitsuba.plugins.coats import raised


class TwoSided(NamedTuple):
    """A proposal for both sides: directions of one, and a cosine lobe on the other side of wi."""

    proposal: Any  # for directions above the horizon
    through: Any  # the probability of the other side

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        near = (1 - self.through) * self.proposal.pdf(raised(wi), raised(wo))
        return dr.select(wi.z * wo.z > 0, near, self.through * dr.inv_pi * dr.abs(wo.z))

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        crosses = choice < self.through
        own = dr.clip((choice - self.through) / dr.maximum(1 - self.through, 1e-6), 0, 0.99999994)
        near = self.proposal.sample(raised(wi), own, u)
        wo = dr.select(crosses, mi.warp.square_to_cosine_hemisphere(u), near)
        return mi.Vector3f(wo.x, wo.y, dr.select((wi.z > 0) != crosses, wo.z, -wo.z))


def relative(wi, wo):
    """wo with z > 0 on the side of wi, and the inverse."""
    return mi.Vector3f(wo.x, wo.y, dr.select(wi.z > 0, wo.z, -wo.z))


def above_surface(si):
    """The interaction seen from the same direction above the surface."""
    seen = mi.SurfaceInteraction3f(si)
    seen.wi = raised(si.wi)
    return seen


def index2(w, index):
    """The square of the index on the side of a direction."""
    return dr.select(w.z > 0, 1, index * index)
