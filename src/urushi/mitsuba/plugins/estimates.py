"""Estimates of what a coat over any BSDF reflects, by the albedo of a coated Lambertian surface.

`core.appearance` has the albedo. It has two uses. Textures of spectral variants have codes at three
bands; f at other wavelengths follows the albedo for the values of coat and bottom there, in which f
is nearly linear. And the option `energy_compensation` gives back the light that a rough surface
loses, by a lobe of the colour of this albedo, which `walk.simulate` defines.
"""

from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.appearance import WI, WO, coated_albedo, coated_color
from urushi.core.namespace import DRJIT
from urushi.mitsuba import spectrum
from urushi.mitsuba.interface_albedo import InterfaceLoss
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import CoatTextures

#: Samples from which the albedo of a bottom is estimated.
SAMPLES = 1 << 14


def estimates(coat: CoatTextures, bottom: "mi.BSDF", si, active) -> tuple[Any, list]:
    """Albedos of a coat over a bottom, up to a factor: at si's wavelengths, and at three bands."""
    at_bands = mi.SurfaceInteraction3f(si)
    spectrum.set_bands(at_bands)
    own, bands = (
        coated_albedo(coat.evaluate(x, active), reflectance(bottom, x, active), DRJIT)
        for x in (si, at_bands)
    )
    return own, list(bands)[: len(spectrum.RGB)]


def reflectance(bottom: "mi.BSDF", si, active):
    """pi f of a bottom away from its mirror direction, in [0, 1]."""
    seen, wo = mi.SurfaceInteraction3f(si), mi.Vector3f(*WO)
    seen.wi = mi.Vector3f(*WI)
    return dr.clip(bottom.eval(mi.BSDFContext(), seen, wo, active) * (dr.pi / WO[2]), 0, 1)


class Compensation:
    """The lobe of the light that the surface of a coat over a bottom loses."""

    DRJIT_STRUCT: ClassVar = {"_gloss": object, "_loss": object}  # for frozen functions

    def __init__(self, coat: CoatTextures, bottom: "mi.BSDF"):
        """Estimate what the bottom mirrors, a constant: light beyond `reflectance`."""
        self._coat, self._bottom = coat, bottom
        constant = not coat.has_textured_eta and coat.above is None
        self._loss = InterfaceLoss(coat.eta if constant else None)
        up, uv = np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)), np.full((SAMPLES, 2), 0.5)
        si = probing.interaction(up, uv)
        rng = mi.PCG32(size=SAMPLES)
        u = rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
        _, weight = bottom.sample(mi.BSDFContext(), si, *u)
        beyond = dr.mean(weight - reflectance(bottom, si, mi.Bool(True)), axis=1)
        self._gloss = mi.Spectrum(dr.mean(beyond)) if mi.is_spectral else mi.Spectrum(beyond)
        dr.make_opaque(self._gloss)

    def completed(self, f, si, wo, active):
        """f [1/sr] with the light that the surface loses."""
        coat = self._coat.evaluate(si, active)
        alpha, eta = coat.alpha, coat.eta
        if isinstance(alpha, Widths):
            alpha = dr.sqrt(0.5 * (dr.square(alpha.u) + dr.square(alpha.v)))
        below = dr.clip(reflectance(self._bottom, si, active) + self._gloss, 0, 1)
        mirrored = dr.clip(dr.mean(self._gloss) / dr.maximum(dr.mean(below), 1e-6), 0, 1)
        color = coated_color(coat, below, DRJIT)
        vertex = self._loss.seen(self._loss.at(alpha, eta, mirrored), si.wi.z)
        return f + mi.Spectrum(color * self._loss.lobe(vertex, wo))
