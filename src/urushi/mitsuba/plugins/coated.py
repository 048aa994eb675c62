"""Coats over any BSDF: the base of plugins that differ in the model of the stack.

The option `energy_compensation` gives back the light that a rough surface loses, by a lobe that
`walk.simulate` defines. Its colour is the albedo of a coated Lambertian surface, of
`core.appearance`.
"""

import math
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi import checks
from urushi.core.appearance import WI, WO, coated_color
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.plugins.stack import BottomLobes, CoatStack, MitsubaBottom, channel_widths
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.changed import relative_to
from urushi.mitsuba.reading.known import varying_textures
from urushi.mitsuba.reading.nested import (
    LowestInterface,
    check_bottom,
    check_dielectric,
    check_rotation,
    is_dielectric,
    nested_bsdf,
    pane,
)
from urushi.mitsuba.reading.parameters import COAT_PROPERTIES, CoatTextures
from urushi.mitsuba.reading.ranges import check_coat
from urushi.mitsuba.recording import compiled_once
from urushi.mitsuba.surface import KnownSurface, Surface, surface_of
from urushi.mitsuba.tables import InterfaceAlbedo

#: Directions from which the light that a bottom mirrors is estimated, the least tangent of their
#: half vectors, and the repetitions where the bottom is the same everywhere.
NODES, LEAST_TANGENT, SAMPLES = 12, 0.001, 1 << 12


def reflectance(bottom: "mi.BSDF", si, active):
    """pi f of a bottom away from its mirror direction, in [0, 1]."""
    seen, wo = mi.SurfaceInteraction3f(si), mi.Vector3f(*WO)
    seen.wi = mi.Vector3f(*WI)
    return dr.clip(bottom.eval(mi.BSDFContext(), seen, wo, active) * (dr.pi / WO[2]), 0, 1)


def mirrored(bottom: "mi.BSDF", si, active, offset=0.5, turn=0.25):
    """The albedo of a bottom at normal incidence without `reflectance`: light that it mirrors.

    The tangent t of the half vector's angle has `NODES` values of equal ratios, and azimuths in
    steps of 45 degrees. The solid angle of wo is 8 pi t^2 / (1 + t^2)^2 dln(t).

    offset, turn: of the nodes in ln(t) and in the azimuth, in steps.
    """
    seen, step = mi.SurfaceInteraction3f(si), -math.log(LEAST_TANGENT) / NODES
    seen.wi, diffuse = mi.Vector3f(0, 0, 1), reflectance(bottom, si, active) * dr.inv_pi
    total = mi.Spectrum(0)
    for node in range(NODES):
        t = dr.exp(mi.Float(-step) * (node + offset))
        sin, cos = dr.sincos(mi.Float(dr.pi / 4) * (3 * node % 4 + turn))
        t2, c = t * t, 1 / (1 + t * t)
        wo = mi.Vector3f(2 * t * c * cos, 2 * t * c * sin, (1 - t2) * c)
        f_cos = bottom.eval(mi.BSDFContext(), seen, wo, active) - diffuse * wo.z
        total += f_cos * (8 * dr.pi * step * t2 * c * c)
    return dr.maximum(total, 0)


class Compensation:
    """The lobe of the light that the surface of a coat over a bottom loses."""

    def __init__(self, coat: CoatTextures, bottom: "mi.BSDF"):
        """Estimate what the bottom mirrors, unless it varies."""
        self._coat, self._bottom = coat, bottom
        constant = not coat.has_textured_eta and coat.above is None
        eta = coat.eta if constant else None
        self._above = InterfaceAlbedo(eta, coat.is_anisotropic)
        self._inside = InterfaceAlbedo(None if eta is None else 1 / eta, coat.is_anisotropic)
        self._gloss: Any = None  # what the bottom mirrors, if it is the same everywhere
        if not varying_textures(bottom):
            up, places = np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)), np.zeros((SAMPLES, 2))
            si = probing.interaction(up, places, np.arange(SAMPLES))
            rng = mi.PCG32(size=SAMPLES)
            gloss = mirrored(bottom, si, mi.Bool(True), rng.next_float32(), 4 * rng.next_float32())
            gloss = dr.mean(gloss, axis=1)
            self._gloss = mi.Spectrum(dr.mean(gloss) if mi.is_spectral else gloss)
            dr.make_opaque(self._gloss)

    def with_lost_light(self, f, si, wo, active):
        """f [1/sr] with the light that the surface loses."""
        coat = self._coat.evaluate(si, active)
        gloss = self._gloss
        if gloss is None:
            gloss = compiled_once(partial(mirrored, self._bottom), si, active)
        below = dr.clip(reflectance(self._bottom, si, active) + gloss, 0, 1)
        share = dr.clip(dr.mean(gloss) / dr.maximum(dr.mean(below), 1e-6), 0, 1)
        color = coated_color(coat, below, DRJIT)
        widths = channel_widths(coat.alpha)
        lobes = [self._lobe(alpha, coat.eta, share, si.wi, wo) for alpha in widths]
        return f + color * mi.Spectrum(*lobes)

    def _lobe(self, alpha, eta, mirrored, wi, wo):
        """The lobe [1/sr] of the light that the interface loses over a white base.

        A loss 1 - A(w) returns as (1 - A(wi)) (1 - A(wo)) / (pi (1 - A_mean)) (Kulla and Conty
        2017).

        mirrored: share that the base mirrors.
        """
        # Both from one table: what it does not reflect is passed or lost, whatever its error.
        reflected, passed = self._inside.both_mean(alpha, 1 / eta, mirrored)
        leaves = passed / (1 - reflected)  # share of light from the base, over the mean that enters

        def lost(reflected, passed):
            return 1 - reflected - leaves * passed

        one, other = (dr.clip(lost(*self._above.both(w, alpha, eta)), 0, 1) for w in (wi, wo))
        mean = dr.maximum(dr.pi * lost(*self._above.both_mean(alpha, eta)), 1e-5)
        return dr.select(eta == 1, 0, one * other / mean)  # 1: there is no interface


def is_slab(bsdf: "mi.BSDF | None") -> bool:
    """Whether a BSDF is coats over what transmits light, of any plugin."""
    return bsdf is not None and getattr(surface_of(bsdf), "bottom", bsdf) is None


class Coated(Surface):
    """A coat over a BSDF, of any model: its parameters. Subclasses compute values in `_prepare`."""

    PROPERTIES = COAT_PROPERTIES
    _differentiable = False  # by all parameters

    def _load(self, props):
        self._nested = nested_bsdf(props, optional=True)
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
        self._inner = bool(props.get("inner", False))  # whether a slab is a part of another
        if is_dielectric(self._nested):
            check_dielectric(self._nested, self._coat.where)
        elif self._nested is not None and not is_slab(self._nested):
            check_bottom(self._nested, self._coat.where)
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
        nested: Any = None if self._nested is None else relative_to(self._nested, self._coat)
        inner: Any = None if nested is None else surface_of(nested)
        stacked = isinstance(inner, type(self))
        self.lowest: LowestInterface | None = None
        if is_dielectric(self._nested):
            thin = self._nested.class_name() == "ThinDielectric"
            self.coats = [self._coat, *([pane(nested).relative_to(self._coat)] if thin else [])]
            self.lowest, self.bottom = None if thin else LowestInterface(nested), None
        elif stacked or is_slab(nested):
            self.coats = [self._coat, *inner.coats]
            self.lowest, self.bottom = inner.lowest, inner.bottom
        else:
            self.coats, self.bottom = [self._coat], nested
        if self._nested is not None:
            check_rotation(self._nested, self._coat.where)
        self.compensation = None
        if self.bottom is None and self._coat.compensated:
            raise ParameterError(
                f"{self._where}: energy_compensation needs an opaque bottom; leave it out"
            )
        if self.bottom is None:
            self._prepare_slab()
        else:
            if self._coat.compensated:
                self.compensation = Compensation(self._coat, nested)
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

            if not any(coat.coloured for coat in self.coats):
                return mi.Spectrum(value(spectrum.color_type()))
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
