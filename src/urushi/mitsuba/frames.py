"""Directions in other frames: turned about the normal, and on both sides of a surface."""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.mixture import Mixture
from urushi.walk import slabs


class Turn(NamedTuple):
    """A turn of the tangent about the normal, by the sine and the cosine of its angle."""

    sin: Any
    cos: Any

    @classmethod
    def of(cls, degrees):
        """The turn by an angle [degrees]."""
        return cls(*dr.sincos(degrees * (dr.pi / 180)))

    def inside(self, w):
        """A direction of the shape's frame, in the turned frame."""
        return type(w)(self.cos * w.x + self.sin * w.y, self.cos * w.y - self.sin * w.x, w.z)

    def outside(self, w):
        """A direction of the turned frame, in the shape's."""
        return Turn(-self.sin, self.cos).inside(w)

    def interaction(self, si):
        """The interaction in the turned frame."""
        turned = mi.SurfaceInteraction3f(si)
        turned.wi = self.inside(si.wi)
        s, t = si.sh_frame.s, si.sh_frame.t
        turned.sh_frame.s = self.cos * s + self.sin * t
        turned.sh_frame.t = self.cos * t - self.sin * s
        return turned


class Place(NamedTuple):
    """A surface at a vertex of a path."""

    active: Any  # lanes that the caller wants and whose wi the surface faces
    turn: Turn | None  # of its tangent
    si: Any  # the interaction, in the turned frame
    vertex: Any  # of `Surface._vertex`

    def inside(self, w):
        """A direction of the shape's frame, in the turned frame."""
        return w if self.turn is None else self.turn.inside(w)

    def outside(self, w):
        """A direction of the turned frame, in the shape's."""
        return w if self.turn is None else self.turn.outside(w)


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
