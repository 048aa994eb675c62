"""The base class of the plugins that coat any BSDF: they differ in the model of the stack."""

from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.checks import MIN_INDEX_STEP
from urushi.core.mixture import Mixture
from urushi.errors import ParameterError
from urushi.mitsuba.latents import baking
from urushi.mitsuba.offers import Offer
from urushi.mitsuba.plugins.coats import (
    BottomLobes,
    CoatStack,
    MitsubaBottom,
    SlabMixture,
    Turn,
    TurnedMixture,
    walk_color,
)
from urushi.mitsuba.reading.below import below
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
            self._nested = nested_bsdf(props, optional=True)
            self._coat = CoatTextures(props)
            if self._nested is not None and not self._is_slab(self._nested):
                check_bottom(self._nested, self._coat.where)
            self._prepare()
            self._kept.keep(self)

        def offer(self):
            return Offer(rotated=self._coat.has_rotation)

        @staticmethod
        def _is_slab(bsdf):
            return isinstance(bsdf, CoatedBSDF) and bsdf.bottom is None

        def under(self, coat):
            """See `reading.below.Coatable`."""
            under = self._copy()
            under._coat = self._coat.under(coat)
            under.coats = [under._coat, *self.coats[1:]]
            return under

        def _prepare(self):
            """Check the parameters, flatten nested coats, and estimate the bottom's lobes."""
            baking.check(self._coat)
            nested: Any = None if self._nested is None else below(self._nested, self._coat)
            coated = isinstance(nested, CoatedBSDF)
            self.coats = [self._coat, *(nested.coats if coated else [])]
            self.bottom = nested.bottom if coated else nested
            if self._nested is not None:
                check_rotation(self._nested, self._coat.where)
            if self.bottom is None:
                self._check_slab()
                self._transmit()
            else:
                self.bottom_lobes = nested.bottom_lobes if coated else BottomLobes(self.bottom)

        def _check_slab(self):
            """Refuse slabs of which a part of the light goes straight on, a delta.

            Raises:
                ParameterError: an index is a texture, or all are 1.
            """
            if any(coat.has_textured_eta for coat in self.coats):
                raise ParameterError(
                    f"{self._where}: int_ior is a texture, but a slab, which has no nested BSDF, "
                    "needs one number"
                )
            if all(abs(coat.eta - 1) < MIN_INDEX_STEP for coat in self.coats):
                raise ParameterError(
                    f"{self._where}: no interface bends light through this slab, as int_ior and "
                    "ext_ior are equal; give another int_ior, or nest a BSDF"
                )

        def _model(self, coats: CoatStack, bottom: MitsubaBottom | None, si, wo, color, active):
            """f [1/sr] of coats over a bottom, of the type `color`, a subclass's; None: a slab."""
            raise NotImplementedError

        def _f(self, vertex, ctx, si, wo, active):
            def evaluated(si, wo, active):
                if self._coat.has_rotation:
                    turn = Turn(*self._coat.turn(si, active))
                    si, wo = turn.interaction(si), turn.inside(wo)

                def value(color, channel=None):
                    coats = CoatStack(self.coats, si, active, channel)
                    bottom = None
                    if self.bottom is not None:
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
            mixture: Mixture | SlabMixture
            if self.bottom is None:
                mixture = coats.slab_proposal(si.wi)
            else:
                mixture = coats.proposal(self.bottom_lobes, si.wi.z, widened)
            if not self._coat.has_rotation:
                return mixture
            return TurnedMixture(mixture, Turn(*self._coat.turn(si, active)))

        def traverse(self, callback):
            self._coat.traverse(callback, mi.ParamFlags.NonDifferentiable)
            if self._nested is not None:
                callback.put("bottom", self._nested, mi.ParamFlags.NonDifferentiable)

        def _update(self, keys):
            self._coat.parameters_changed()
            self._prepare()

        def to_string(self):
            bottom = str(self._nested).replace("\n", "\n  ")
            return f"{label}[\n{self._coat},\n  bottom = {bottom}\n]"

    return CoatedBSDF
