"""The option `energy_compensation` of coats: light that a rough surface loses is given back.

`walk.simulate` defines the lobe.
"""

from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.appearance import coated_color
from urushi.core.namespace import DRJIT
from urushi.mitsuba.interface_albedo import InterfaceLoss
from urushi.mitsuba.plugins.estimates import reflectance
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import CoatTextures

#: Samples from which the albedo of a bottom is estimated.
SAMPLES = 1 << 14


class Compensation:
    """The lobe of a coat over a bottom."""

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
