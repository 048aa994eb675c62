"""The turn of the tangent about the normal that coats and codes have as their rotation."""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.mitsuba.reading.parameters import CoatTextures


class TurnedMixture(NamedTuple):
    """A proposal whose tangent is turned about the normal; see `core.mixture.Mixture`."""

    mixture: Any
    turn: "Turn"

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        return self.mixture.pdf(self.turn.inside(wi), self.turn.inside(wo))

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        return self.turn.outside(self.mixture.sample(self.turn.inside(wi), choice, u))


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


def turn_of(coat: CoatTextures, si, active) -> Turn | None:
    """The turn of a coat's tangent, if it has one."""
    if not coat.has_rotation:
        return None
    return Turn.of(coat.textures["rotation"].eval_1(si, active))


def turned(turn: Turn | None, si: Any, wo: Any) -> tuple[Any, Any]:
    """The interaction and wo in the turned frame, if there is a turn."""
    return (si, wo) if turn is None else (turn.interaction(si), turn.inside(wo))
