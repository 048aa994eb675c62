"""The BSDF under a coat: found and checked.

A dielectric of Mitsuba's is the lower interface of a slab, or a pane in air.
"""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import AIR, MIN_ALPHA, MIN_INDEX_STEP
from urushi.errors import ParameterError
from urushi.mitsuba.properties import describe
from urushi.mitsuba.reading.grid import nested_objects, varies
from urushi.mitsuba.reading.parameters import CoatTextures, alpha_of
from urushi.mitsuba.reading.probing import GGX, known_surface
from urushi.mitsuba.recording import opaque

#: Classes of Mitsuba's dielectrics, and their plugins.
DIELECTRICS = {
    "RoughDielectric": "roughdielectric",
    "SmoothDielectric": "dielectric",
    "ThinDielectric": "thindielectric",
}

#: Mitsuba keeps only the ratio of the indices of a dielectric. Indices of materials have at most
#: this number of decimals. If the ratio times the index of air has more, `ext_ior` was not air.
DECIMALS = 4
#: A ratio is taken for one to vacuum from here: no solid or liquid reflects less.
LEAST_IN_VACUUM = 1.3


def nested_bsdf(props: "mi.Properties", *, optional: bool = False) -> Any:
    """The one BSDF among the properties, under any name. Call this before reading textures.

    Listing the objects resets Mitsuba's record of which properties were read.

    optional: return None if there is none.
    """
    found = [
        (name, value)
        for name, value in props.objects(mark_queried=False)
        if isinstance(value, mi.BSDF)
    ]
    if optional and not found:
        return None
    if len(found) != 1:
        named = ", ".join(f"'{name}'" for name, _ in found)
        amount = f"{len(found)} nested BSDFs ({named})" if found else "no nested BSDF"
        raise ParameterError(
            f"{describe(props)} has {amount}; nest exactly one, the bottom under the coat"
        )
    props.mark_queried(found[0][0])
    return _unmasked(found[0][1])


def _unmasked(bsdf: "mi.BSDF") -> "mi.BSDF":
    """The BSDF within a `mask` that is opaque everywhere, which exporters write."""
    while bsdf.class_name() == "MaskBSDF":
        parts = nested_objects(bsdf)
        opacity = parts["opacity"]
        point = dr.zeros(mi.SurfaceInteraction3f)
        if varies(opacity) or opacity.eval_1(point).numpy()[0] < 1:
            break
        bsdf = parts["nested_bsdf"]
    return bsdf


def check_bottom(bsdf: "mi.BSDF", where: str) -> None:
    """Refuse BSDFs that cannot be coated: those that transmit light or have a delta lobe."""
    flags, has = bsdf.flags(), mi.has_flag
    if has(flags, mi.BSDFFlags.Transmission) or has(flags, mi.BSDFFlags.Null):
        raise ParameterError(
            f"{where}: the nested BSDF transmits light; a coat needs an opaque bottom, a "
            "'roughdielectric', a 'dielectric' or a 'thindielectric'"
        )
    if has(flags, mi.BSDFFlags.Delta):
        raise ParameterError(
            f"{where}: the nested BSDF is perfectly smooth; give its rough variant, such as "
            "'roughconductor' of alpha 0.01"
        )


def check_rotation(bottom: "mi.BSDF", where: str) -> None:
    """Refuse, by a ParameterError, a bottom with a rotation of its own."""
    if known_surface(bottom).rotated:
        raise ParameterError(
            f"{where}: the nested coat has its own rotation, but all layers share one tangent "
            "frame; give rotation to the outermost coat only"
        )


class LowestInterface:
    """The surface of a body of glass under coats: a `roughdielectric` or a `dielectric`."""

    def __init__(self, bsdf: "mi.BSDF"):
        textures = nested_objects(bsdf)
        names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
        self.textures = {name: textures[name] for name in names if name in textures}  # of widths
        self.index = opaque(index_of(bsdf))  # of the body, relative to air

    @property
    def is_anisotropic(self) -> bool:
        return len(self.textures) == 2

    def alpha(self, si, active):
        """The GGX width, or two `Widths`; a smooth surface has the least one."""
        widths = [texture.eval_1(si, active) for texture in self.textures.values()]
        return alpha_of(widths or [mi.Float(MIN_ALPHA)])


def is_dielectric(bsdf: "mi.BSDF | None") -> bool:
    """Whether a BSDF is one of Mitsuba's dielectrics."""
    return bsdf is not None and bsdf.class_name() in DIELECTRICS


def pane(bsdf: "mi.BSDF") -> CoatTextures:
    """The clear, smooth coat that a `thindielectric` is above its lower interface."""
    props = mi.Properties("thindielectric")
    props["alpha"], props["int_ior"] = MIN_ALPHA, index_of(bsdf) * AIR
    return CoatTextures(props)


def index_of(bsdf: "mi.BSDF") -> float:
    """The index of refraction of one of `DIELECTRICS` relative to what lies outside, air."""
    return float(np.ravel(mi.traverse(bsdf)["eta"])[0])


def check_dielectric(bsdf: "mi.BSDF", where: str) -> None:
    """Refuse dielectrics that are no interfaces of the walk."""
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
    ratio = index_of(bsdf)
    vacuum = ratio > LEAST_IN_VACUUM and _is_plain(ratio)
    if not (vacuum or abs(ratio - 1) < MIN_INDEX_STEP or _is_plain(ratio * AIR)):
        raise ParameterError(
            f"{where}: the index of the nested '{name}' relative to its ext_ior is {ratio:.5g}, "
            "from which its index in air does not follow; leave out ext_ior, since indices are "
            f"absolute, and give int_ior with at most {DECIMALS} decimals"
        )


def _is_plain(index: float) -> bool:
    """Whether an index was given with at most `DECIMALS` decimals, up to single precision."""
    return abs(index - round(index, DECIMALS)) < 2e-7 * index
