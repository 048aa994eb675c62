"""Directions and proposals on both sides of a surface."""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.mixture import Mixture
from urushi.walk import slabs


class SlabMixture(NamedTuple):
    """A proposal for both sides of a slab."""

    mixture: Mixture  # of reflected directions
    # Of transmitted directions, as a mirror would reflect them that reflects wi where straight
    # light goes, mirrored through the slab.
    passed: Mixture
    reflected: Any  # the probability of reflection
    eta: Any  # index on the far side relative to that on wi's

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]; zero at the horizon."""
        reflected = self.reflected * self.mixture.pdf(raised(wi), raised(wo))
        straight = slabs.straight(raised(wi), self.eta)
        passed = (1 - self.reflected) * self.passed.pdf(straight, raised(wo))
        return dr.select(wi.z * wo.z > 0, reflected, passed)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        reflects = choice < self.reflected
        choice = dr.select(reflects, choice, choice - self.reflected)
        choice /= dr.select(reflects, self.reflected, 1 - self.reflected)
        reflected = self.mixture.sample(raised(wi), choice, u)
        passed = self.passed.sample(slabs.straight(raised(wi), self.eta), choice, u)
        wo = dr.select(reflects, reflected, passed)
        return type(wo)(wo.x, wo.y, dr.select((wi.z > 0) == reflects, wo.z, -wo.z))


def with_far_side(mixture, through) -> SlabMixture:
    """A proposal of one side, and a cosine lobe on the other side of wi.

    through: the probability of the other side.
    """
    return SlabMixture(mixture, Mixture([0.0, 1.0], [1.0]), 1 - through, 1.0)


def raised(w):
    """A direction, mirrored to the upper side."""
    return type(w)(w.x, w.y, dr.abs(w.z))


def relative(wi, wo):
    """wo with z > 0 on the side of wi, and the inverse."""
    return type(wo)(wo.x, wo.y, dr.select(wi.z > 0, wo.z, -wo.z))


def above_surface(si):
    """The interaction seen from the same direction above the surface."""
    seen = mi.SurfaceInteraction3f(si)
    seen.wi = raised(si.wi)
    return seen
