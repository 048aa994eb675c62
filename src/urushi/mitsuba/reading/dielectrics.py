"""Mitsuba's dielectrics under coats: the lower interface of a slab, or a pane in air."""

import mitsuba as mi
import numpy as np

from urushi.checks import AIR, MIN_ALPHA, Widths
from urushi.errors import ParameterError
from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.reading.offers import GGX
from urushi.mitsuba.reading.parameters import CoatTextures, opaque

#: Classes of Mitsuba's dielectrics, and their plugins.
DIELECTRICS = {
    "RoughDielectric": "roughdielectric",
    "SmoothDielectric": "dielectric",
    "ThinDielectric": "thindielectric",
}


class LowestInterface:
    """The surface of a body of glass under coats: a `roughdielectric` or a `dielectric`.

    Attributes:
        index: of the body, relative to air.
        textures: of its widths, by name.
    """

    def __init__(self, bsdf: "mi.BSDF"):
        textures = nested_objects(bsdf)
        names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
        self.textures = {name: textures[name] for name in names if name in textures}
        self.index = opaque(index_of(bsdf))

    @property
    def is_anisotropic(self) -> bool:
        return len(self.textures) == 2

    def alpha(self, si, active):
        """The GGX width, or two `Widths`; a smooth surface has the least one."""
        widths = [texture.eval_1(si, active) for texture in self.textures.values()]
        return Widths(*widths) if self.is_anisotropic else (widths or [mi.Float(MIN_ALPHA)])[0]


def pane(bsdf: "mi.BSDF") -> CoatTextures:
    """The clear, smooth coat that a `thindielectric` is above its lower interface."""
    props = mi.Properties("thindielectric")
    props["alpha"], props["int_ior"] = MIN_ALPHA, index_of(bsdf) * AIR
    return CoatTextures(props)


def index_of(bsdf: "mi.BSDF") -> float:
    """The index of refraction of one of `DIELECTRICS` relative to what lies outside, air."""
    return float(np.ravel(mi.traverse(bsdf)["eta"])[0])


def check_dielectric(bsdf: "mi.BSDF", where: str) -> None:
    """Refuse dielectrics that are no interfaces of the walk.

    Raises:
        ParameterError: it is tinted, or its facets are not GGX's.
    """
    name = DIELECTRICS[bsdf.class_name()]
    tints = [tint for tint in nested_objects(bsdf) if tint.startswith("specular")]
    if tints:
        raise ParameterError(
            f"{where}: the nested '{name}' has a {tints[0]}, which no interface has; "
            "give colour by albedo and sigma_t of the coat"
        )
    if name == "roughdielectric" and GGX not in str(bsdf):
        raise ParameterError(
            f"{where}: the nested 'roughdielectric' has the distribution 'beckmann'; give 'ggx', "
            "which all interfaces of a stack have"
        )
