"""What is known of a BSDF besides its values, for a coat above it.

Of Mitsuba's own, `roughconductor` with the GGX distribution is a lobe and nothing else,
`roughplastic` and an isotropic `pplastic` have one, and `diffuse` has none. All are read from their
parameters. Others are known by their values alone.
"""

from collections.abc import Mapping
from functools import partial

import drjit as dr
import mitsuba as mi

from urushi.checks import MIN_ALPHA
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.surface import KnownSurface, surface_of
from urushi.nets.lobe import NO_LOBE

#: The line of a BSDF's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"

#: Mitsuba's rough plastics.
PLASTICS = ("RoughPlastic", "PolarizedPlastic")


def known_surface(bsdf: "mi.BSDF") -> KnownSurface:
    """What is known of a BSDF, or of the front side of Mitsuba's `twosided`."""
    surface = surface_of(bsdf)
    if surface is not None:
        return surface.known()
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = nested_objects(bsdf)["brdf_0"]
    if bsdf.class_name() == "SmoothDiffuse":
        count = len(spectrum.to_channels(mi.Spectrum(0)))
        return KnownSurface(lobes=lambda si: [[*map(mi.Float, NO_LOBE)]] * count)
    plastic = bsdf.class_name() in PLASTICS and "alpha_u" not in nested_objects(bsdf)
    if plastic and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_plastic_lobes, bsdf), table_source=lambda: bsdf)
    if bsdf.class_name() == "RoughConductor" and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_conductor_lobes, nested_objects(bsdf)), lobe_only=True)
    return KnownSurface()


def _conductor_lobes(textures: Mapping[str, "mi.Texture"], si) -> list[list]:
    """The lobes of a conductor: six or seven Dr.Jit floats for each channel."""
    names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
    given = (textures[name].eval_1(si) for name in names)
    # The derivative passes the bound, so that an optimiser can leave it.
    alpha, *across = (dr.replace_grad(dr.maximum(x, MIN_ALPHA), x) for x in given)
    columns = [_channels(textures, x, si) for x in ("specular_reflectance", "eta", "k")]
    found = []
    for reflectance, eta, k in zip(*columns, strict=True):
        # Mitsuba's metal "none" has the index 0 and reflects all light.
        exact = eta > 0
        schlick = dr.select(exact, 0, reflectance)
        index = dr.select(exact, eta, NO_LOBE[4]), dr.select(exact, k, 0)
        factors = schlick, schlick, dr.select(exact, reflectance, 0)
        found.append([alpha, *factors, *index, *across])
    return found


def _plastic_lobes(plastic: "mi.BSDF", si) -> list[list]:
    """The lobes of a plastic: six Dr.Jit floats for each channel."""
    given, textures, zero = mi.traverse(plastic), nested_objects(plastic), mi.Float(0)
    alpha, eta = (
        textures[name].eval_1(si) if name in textures else mi.Float(given[name])
        for name in ("alpha", "eta")
    )
    alpha = dr.replace_grad(dr.maximum(alpha, MIN_ALPHA), alpha)
    tints = _channels(textures, "specular_reflectance", si)
    return [[alpha, zero, zero, tint, eta, zero] for tint in tints]


def _channels(textures: Mapping[str, "mi.Texture"], name: str, si) -> list:
    """The channels of a texture; ones if it is missing."""
    if name in textures:
        return spectrum.to_channels(textures[name].eval(si))
    return [mi.Float(1)] * len(spectrum.to_channels(mi.Spectrum(0)))
