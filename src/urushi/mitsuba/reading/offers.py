"""What a BSDF tells the coat above it, besides its values.

Of Mitsuba's own, `roughconductor` with the GGX distribution is a lobe and nothing else,
`roughplastic` and an isotropic `pplastic` have one, and `diffuse` has none; so has a `blendbsdf` of
`diffuse` and one of them. All are read from their parameters. Others are known by their values
alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, runtime_checkable

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.material.material import Material
from urushi.measured.tabulated import MeasuredSurface
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import nested_objects
from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model

#: The line of a BSDF's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"

#: Mitsuba's rough plastics.
PLASTICS = ("RoughPlastic", "PolarizedPlastic")


class Latents(Protocol):
    """The codes of a plugin, one per channel or a texture of them; see `latents.codes`."""

    @property
    def model(self) -> Model:
        """The weights that they belong to."""

    @property
    def channels(self) -> int:
        """Number of codes, one per channel."""

    @property
    def material(self) -> Material | None:
        """The material of codes that are the same everywhere; None: they vary."""

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2)."""


@dataclass(frozen=True)
class Offer:
    """What a BSDF offers to a coat; by default nothing. `si` is a surface interaction."""

    latents: Latents | None = None  # its codes
    measured: MeasuredSurface | None = None  # the measurement that it renders
    # From si to the analytic lobes (`urushi.nets.lobe`): six Dr.Jit floats for each channel, seven
    # of an anisotropic BSDF; None if they are not known.
    lobes: Callable[[Any], list[list] | None] = lambda si: None
    bare: bool = False  # whether it is its lobe and nothing else
    # From si to the reflectance of each channel of a Lambertian BSDF; None: it is not Lambertian.
    reflectance: Callable[[Any], list] | None = None
    # The BSDF whose values a table holds where the codes have others; None: there is none.
    exact: Callable[[], "mi.BSDF | None"] = lambda: None
    rotated: bool = False  # whether its tangent is turned about the normal


@runtime_checkable
class Offering(Protocol):
    """A BSDF of this package."""

    def offer(self) -> Offer:
        """Its present offer; parameters may change it."""


def offer_of(bsdf: "mi.BSDF") -> Offer:
    """What a BSDF offers, or the front side of Mitsuba's `twosided`."""
    if isinstance(bsdf, Offering):
        return bsdf.offer()
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = nested_objects(bsdf)["brdf_0"]
    if bsdf.class_name() == "SmoothDiffuse":
        channels = partial(_channels, nested_objects(bsdf), "reflectance")
        return Offer(
            lobes=lambda si: [[*map(mi.Float, NO_LOBE)] for _ in channels(si)],
            reflectance=channels,
        )
    plastic = bsdf.class_name() in PLASTICS and "alpha_u" not in nested_objects(bsdf)
    if plastic and GGX in str(bsdf):
        return Offer(lobes=partial(_plastic_lobes, bsdf), exact=lambda: bsdf)
    if bsdf.class_name() == "BlendBSDF":
        return _blend_offer(bsdf)
    if bsdf.class_name() == "RoughConductor" and GGX in str(bsdf):
        return Offer(lobes=partial(_conductor_lobes, nested_objects(bsdf)), bare=True)
    return Offer()


def _blend_offer(blend: "mi.BSDF") -> Offer:
    """The lobe of a `blendbsdf` of a Lambertian BSDF and one of a known lobe; else nothing."""
    parts = nested_objects(blend)
    offers = [offer_of(parts[name]) for name in ("bsdf_0", "bsdf_1")]
    glossy = [index for index, offer in enumerate(offers) if offer.reflectance is None]
    if len(glossy) != 1 or not (offers[glossy[0]].bare or offers[glossy[0]].exact()):
        return Offer()
    lobes_of_part = offers[glossy[0]].lobes

    def lobes(si) -> list[list] | None:
        weight = dr.clip(parts["weight"].eval_1(si), 0, 1)
        share = weight if glossy[0] else 1 - weight
        found = lobes_of_part(si)
        return found and [[x[0], *(share * y for y in x[1:4]), *x[4:]] for x in found]

    return Offer(lobes=lobes, exact=lambda: blend)


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


def tabulated(latents: Latents | None) -> Material | None:
    """The material of latents that are evaluated by a table, not by their codes; else None."""
    material = None if latents is None else latents.material
    return None if material is None or material.table is None else material
