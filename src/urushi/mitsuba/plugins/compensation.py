"""The option `energy_compensation` of coats over any BSDF.

It gives back the light that a rough surface loses, by a lobe that `walk.simulate` defines. Its
colour is the albedo of a coated Lambertian surface, of `core.appearance`.
"""

import math
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.appearance import WI, WO, coated_color
from urushi.core.namespace import DRJIT
from urushi.mitsuba.plugins.stack import channel_widths
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.recording import compiled_once
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
        reflected, passed = self._inside.both(None, alpha, 1 / eta, mirrored)
        leaves = passed / (1 - reflected)  # share of light from the base, over the mean that enters

        def lost(reflected, passed):
            return 1 - reflected - leaves * passed

        one, other = (dr.clip(lost(*self._above.both(w, alpha, eta)), 0, 1) for w in (wi, wo))
        mean = dr.maximum(dr.pi * lost(*self._above.both(None, alpha, eta)), 1e-5)
        return dr.select(eta == 1, 0, one * other / mean)  # 1: there is no interface
