"""Coats over any BSDF: the base of plugins that differ in the model of the stack."""

import math
from typing import Any

import drjit as dr
import mitsuba as mi

from urushi import checks
from urushi.errors import ParameterError
from urushi.mitsuba.plugins.compensation import Compensation
from urushi.mitsuba.plugins.stack import BottomLobes, CoatStack, MitsubaBottom
from urushi.mitsuba.reading import nested
from urushi.mitsuba.reading.changed import relative_to
from urushi.mitsuba.reading.parameters import COAT_PROPERTIES, CoatTextures
from urushi.mitsuba.reading.ranges import check_coat
from urushi.mitsuba.recording import compiled_once
from urushi.mitsuba.surface import KnownSurface, Surface, surface_of


def is_slab(bsdf: "mi.BSDF | None") -> bool:
    """Whether a BSDF is coats over what transmits light, of any plugin."""
    return bsdf is not None and getattr(surface_of(bsdf), "bottom", bsdf) is None


class Coated(Surface):
    """A coat over a BSDF, of any model: its parameters. Subclasses compute values in `_prepare`."""

    PROPERTIES = COAT_PROPERTIES
    _differentiable = False  # by all parameters

    def _load(self, props):
        self._nested = nested.nested_bsdf(props, optional=True)
        self._coat = CoatTextures(props)

    def _prepare(self):
        """Compute what follows from the parameters."""

    def known(self):
        return KnownSurface(rotated=self._coat.has_rotation)

    def _turn(self, si, active):
        return self._coat.turn(si, active)

    def traverse(self, callback):
        flags = mi.ParamFlags
        own = flags.Differentiable if self._differentiable else flags.NonDifferentiable
        self._coat.traverse(callback, own)
        if self._nested is not None:
            callback.put("bottom", self._nested, own)

    def _update(self, keys):
        self._coat.parameters_changed()
        self._prepare()

    def _details(self) -> str:
        """Lines of `to_string` beside those of the parameters."""
        return ""

    def to_string(self):
        bottom = str(self._nested).replace("\n", "\n  ")
        name = type(self).__name__
        return f"{name}[\n{self._coat},\n{self._details()}  bottom = {bottom}\n]"


class CoatedSurface(Coated):
    """Coats over a BSDF; directly nested ones of the same plugin form one stack."""

    def _load(self, props):
        super()._load(props)
        for name in ("resolution", "weights"):  # Mitsuba refuses properties that nobody reads
            props.get(name, None)
        self._inner = bool(props.get("inner", False))  # whether a slab is a part of another
        if nested.is_dielectric(self._nested):
            nested.check_dielectric(self._nested, self._coat.where)
        elif self._nested is not None and not is_slab(self._nested):
            nested.check_bottom(self._nested, self._coat.where)
        self._prepare()

    def relative_to(self, coat):
        """See `Surface.relative_to`."""
        under = self._copy()
        under._coat = self._coat.relative_to(coat)
        under.coats = [under._coat, *self.coats[1:]]
        return under

    def _prepare(self):
        """Check the parameters, flatten nested coats, and estimate the bottom's lobes."""
        check_coat(self._coat)
        below: Any = None if self._nested is None else relative_to(self._nested, self._coat)
        inner: Any = None if below is None else surface_of(below)
        stacked = isinstance(inner, type(self))
        self.lowest: nested.LowestInterface | None = None
        if nested.is_dielectric(self._nested):
            thin = self._nested.class_name() == "ThinDielectric"
            panes = [nested.pane(below).relative_to(self._coat)] if thin else []
            self.coats = [self._coat, *panes]
            self.lowest, self.bottom = None if thin else nested.LowestInterface(below), None
        elif stacked or is_slab(below):
            self.coats = [self._coat, *inner.coats]
            self.lowest, self.bottom = inner.lowest, inner.bottom
        else:
            self.coats, self.bottom = [self._coat], below
        if self._nested is not None:
            nested.check_rotation(self._nested, self._coat.where)
        self.compensation = None
        if self.bottom is None and self._coat.compensated:
            raise ParameterError(
                f"{self._where}: energy_compensation needs an opaque bottom; leave it out"
            )
        if self.bottom is None:
            self._prepare_slab()
        else:
            if self._coat.compensated:
                self.compensation = Compensation(self._coat, below)
            self.bottom_lobes = inner.bottom_lobes if stacked else BottomLobes(self.bottom)

    def _prepare_slab(self):
        """Set the index below, and refuse slabs through which light goes straight, a delta."""
        index = None if self.lowest is None else self.lowest.index / self._coat.outside
        self._transmit(index)
        textured = any(coat.has_textured_eta for coat in self.coats)
        if textured and index is None:
            raise ParameterError(
                f"{self._where}: int_ior is a texture, but a slab with air on both sides "
                "needs one number"
            )
        if textured or self._inner:
            return
        beyond = 1.0 if index is None else float(index.numpy()[0])
        etas = [coat.eta for coat in self.coats]
        where = f"{self._where}: the index below the slab relative to int_ior"
        etas.append(float(checks.eta(beyond / math.prod(etas), where, low=checks.LEAST_ETA_BELOW)))
        if all(abs(eta - 1) < checks.MIN_INDEX_STEP for eta in etas):
            raise ParameterError(
                f"{self._where}: no interface bends light through this slab, as int_ior and "
                "ext_ior are equal; give another int_ior, or nest a BSDF"
            )

    def _model(self, coats: CoatStack, bottom: Any, si, wo, color, active):
        """f [1/sr] of importance, of the type `color`, a subclass's.

        bottom: a `MitsubaBottom`, or the `Reflector` that is the lowest interface of a slab.
        """
        raise NotImplementedError

    def _lowest_at(self, coats: CoatStack, si, active):
        """The lowest interface of a slab at a surface interaction."""
        alpha = None if self.lowest is None else self.lowest.alpha(si, active)
        return coats.lowest(self._index, alpha)

    def _f(self, vertex, ctx, si, wo, active):
        def evaluated(si, wo, active):
            def value(color, channel=None):
                coats = CoatStack(self.coats, si, active, channel)
                if self.bottom is None:
                    bottom = self._lowest_at(coats, si, active)
                else:
                    bottom = MitsubaBottom(self.bottom, ctx, si, active, channel)
                return self._model(coats, bottom, si, wo, color, active)

            if not (mi.is_monochromatic or any(coat.coloured for coat in self.coats)):
                return mi.Spectrum(value(mi.Spectrum))
            # Every channel has a stack of its own.
            channels = range(dr.size_v(mi.Spectrum))
            return mi.Spectrum(*(value(mi.Float, channel) for channel in channels))

        f = compiled_once(evaluated, si, wo, active)
        if self.compensation is not None:
            f = self.compensation.with_lost_light(f, si, wo, active)
        if self.lowest is None or ctx.mode == mi.TransportMode.Importance:
            return f
        return f / dr.select(si.wi.z * wo.z < 0, dr.square(self._index_across(si.wi)), 1)

    def _proposal(self, vertex, si, active):
        coats = CoatStack(self.coats, si, active)
        if self.bottom is None:
            return coats.slab_proposal(si.wi, self._lowest_at(coats, si, active))
        return coats.proposal(self.bottom_lobes, si.wi.z)
