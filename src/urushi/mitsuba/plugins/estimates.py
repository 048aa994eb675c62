"""Estimates of coated albedos, by which textures have a spectrum between their bands.

Textures of spectral variants have codes at three bands. f at other wavelengths follows the albedo
of a Lambertian bottom under the coat (`core.appearance.coated_albedo`), for the values of coat and
bottom at these wavelengths. f is nearly linear in this albedo.
"""

from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.core.appearance import WI, WO, coated_albedo
from urushi.core.namespace import DRJIT
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.parameters import CoatTextures


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
