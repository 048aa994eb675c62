"""The base class of the plugins that coat any BSDF: they differ in the model of the stack."""

import drjit as dr
import mitsuba as mi

from urushi.mitsuba.latents import baking
from urushi.mitsuba.offers import Offer
from urushi.mitsuba.plugins.coats import (
    BottomLobes,
    CoatStack,
    MitsubaBottom,
    Turn,
    TurnedMixture,
    walk_color,
)
from urushi.mitsuba.reading.parameters import (
    CoatTextures,
    check_bottom,
    check_rotation,
    nested_bsdf,
)
from urushi.mitsuba.recording import compiled_once


def define_coated(base: type, label: str, *, widened: bool) -> type:
    """Make the base class in the current variant.

    Args:
        base: of `define_proposal_bsdf`.
        label: name in descriptions.
        widened: as of `CoatStack.proposal`.
    """

    class CoatedBSDF(base):
        """Coats over a BSDF; directly nested ones of the same plugin form one stack."""

        def __init__(self, props):
            super().__init__(props)
            self._nested = nested_bsdf(props)
            self._coat = CoatTextures(props)
            check_bottom(self._nested, self._coat.where)
            self._prepare()
            self._kept.keep(self)

        def offer(self):
            return Offer(rotated=self._coat.has_rotation)

        def _prepare(self):
            """Check the parameters, flatten nested coats, and estimate the bottom's lobes."""
            baking.check(self._coat)
            check_rotation(self._nested, self._coat.where)
            below = isinstance(self._nested, CoatedBSDF)
            self.coats = [self._coat, *(self._nested.coats if below else [])]
            self.bottom = self._nested.bottom if below else self._nested
            self.bottom_lobes = self._nested.bottom_lobes if below else BottomLobes(self.bottom)

        def _model(self, coats: CoatStack, bottom: MitsubaBottom, si, wo, color, active):
            """The BRDF [1/sr] of coats over a bottom, of the type `color`, a subclass's."""
            raise NotImplementedError

        def _f(self, vertex, ctx, si, wo, active):
            def evaluated(si, wo, active):
                if self._coat.has_rotation:
                    turn = Turn(*self._coat.turn(si, active))
                    si, wo = turn.interaction(si), turn.inside(wo)

                def value(color, channel=None):
                    coats = CoatStack(self.coats, si, active, channel)
                    bottom = MitsubaBottom(self.bottom, ctx, si, active, channel)
                    return self._model(coats, bottom, si, wo, color, active)

                if not any(coat.coloured for coat in self.coats):
                    return mi.Spectrum(value(walk_color()))
                # Every channel has a stack of its own.
                channels = range(dr.size_v(mi.Spectrum))
                return mi.Spectrum(*(value(mi.Float, channel) for channel in channels))

            return compiled_once(evaluated, si, wo, active)

        def _proposal(self, vertex, si, active):
            coats = CoatStack(self.coats, si, active)
            mixture = coats.proposal(self.bottom_lobes, si.wi.z, widened)
            if not self._coat.has_rotation:
                return mixture
            return TurnedMixture(mixture, Turn(*self._coat.turn(si, active)))

        def traverse(self, callback):
            self._coat.traverse(callback, mi.ParamFlags.NonDifferentiable)
            callback.put("bottom", self._nested, mi.ParamFlags.NonDifferentiable)

        def _update(self, keys):
            self._coat.parameters_changed()
            self._prepare()

        def to_string(self):
            bottom = str(self._nested).replace("\n", "\n  ")
            return f"{label}[\n{self._coat},\n  bottom = {bottom}\n]"

    return CoatedBSDF
