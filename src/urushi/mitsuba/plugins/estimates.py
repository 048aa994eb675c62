"""Estimates of coated albedos, by which textures have a spectrum between their bands.

Textures of spectral variants have codes at three bands. f at other wavelengths follows the albedo
of a Lambertian bottom under a medium (Kubelka and Munk 1931) and an interface (Saunderson 1942),
for the values of coat and bottom at these wavelengths. f is nearly linear in this albedo.
"""

from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.checks import CoatParameters
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.parameters import CoatTextures

#: The pair of directions at which the bottom is evaluated, away from its mirror direction.
WI, WO = (0.6, 0.0, 0.8), (0.0, 0.6, 0.8)

#: Path of light through a medium over its depth: from outside and diffuse; and the share of
#: isotropic scattering that turns light back.
REFRACTED, DIFFUSE, BACKWARDS = 1.15, 2.0, 0.5


def estimates(coat: CoatTextures, bottom: "mi.BSDF", si, active) -> tuple[Any, list]:
    """Albedos of a coat over a bottom, up to a factor: at si's wavelengths, and at three bands."""
    at_bands = mi.SurfaceInteraction3f(si)
    spectrum.set_bands(at_bands)
    own, bands = (
        albedo(coat.evaluate(x, active), reflectance(bottom, x, active)) for x in (si, at_bands)
    )
    return own, list(bands)[: len(spectrum.RGB)]


def reflectance(bottom: "mi.BSDF", si, active):
    """pi f of a bottom away from its mirror direction, in [0, 1]."""
    seen, wo = mi.SurfaceInteraction3f(si), mi.Vector3f(*WO)
    seen.wi = mi.Vector3f(*WI)
    return dr.clip(bottom.eval(mi.BSDFContext(), seen, wo, active) * (dr.pi / WO[2]), 0, 1)


def albedo(coat: CoatParameters, reflectance):
    """The share of the light that enters a coat over a Lambertian reflectance and leaves again."""

    def without_interface(path):
        scattered = coat.sigma_t * coat.albedo
        absorption = path * (coat.sigma_t - scattered)
        scattering = path * BACKWARDS * scattered * (1 - coat.g)
        both = absorption + scattering
        root = dr.sqrt(absorption * (both + scattering) + 1e-6)
        decay = root / dr.tanh(root)
        divisor = both - reflectance * scattering + decay
        return (scattering - reflectance * (both - decay)) / divisor

    kept_inside = dr.maximum(1 - 1 / dr.square(coat.eta), 0)
    entering = dr.lerp(REFRACTED, DIFFUSE, coat.albedo)  # what is scattered is diffuse
    inside = without_interface(DIFFUSE)
    return (1 - kept_inside) * without_interface(entering) / (1 - kept_inside * inside)
