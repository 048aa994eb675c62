"""Mitsuba BSDFs below the medium of a coat.

Indices of refraction become relative to that medium. Of Mitsuba's dielectrics, one becomes the
lower interface of a slab, or a pane in air.
"""

import itertools
from typing import Any, ClassVar

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.checks import AIR, MIN_ALPHA, MIN_INDEX_STEP, Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.derived import derived
from urushi.mitsuba.reading.grid import NORMALS, nested_objects
from urushi.mitsuba.reading.known import GGX
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.recording import opaque
from urushi.mitsuba.surface import bsdf_of, surface_of

#: Classes of Mitsuba's BSDFs that reflect as the BSDFs nested in them, and their plugins.
WRAPPERS = NORMALS | {"BlendBSDF": "blendbsdf"}

#: Properties of `normalmap` and `bumpmap` that they do not list, by default true, and the number of
#: pairs at which they are found.
SWITCHES, SWITCH_PAIRS = ("use_shadowing_function", "flip_invalid_normals"), 1024


class Medium:
    """A medium of a constant index relative to air, in place of the coat that contains it."""

    has_textured_eta = False  # see `CoatTextures`

    def __init__(self, index: npt.ArrayLike):
        """index: a number, or one per channel."""
        self.opaque_eta = (mi.Float if np.ndim(index) == 0 else mi.Spectrum)(index)

    def inside(self, si, active=True) -> Any:
        """See `CoatTextures.inside`."""
        return self.opaque_eta

    def put_index(self, callback) -> None:
        """See `CoatTextures.put_index`."""
        callback.put("ext_eta", self.opaque_eta, mi.ParamFlags.Differentiable)


def bsdf_under(bsdf: "mi.BSDF", index: npt.ArrayLike) -> "mi.BSDF":
    """A BSDF below a medium; see `urushi.walk.stack.under`."""
    return below(bsdf, Medium(index))


def below(bsdf: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """A BSDF as it reflects below the medium of a coat, `CoatTextures` or a `Medium`.

    Coats without `ext_ior`, and saved materials that were layered, keep their absolute indices. The
    index of a `roughconductor` is divided by the medium's, relative to air. So it is for those
    within Mitsuba's `twosided`, `blendbsdf`, `normalmap` and `bumpmap`. All others, such as
    measured BRDFs, are as they are in air.
    """
    surface = surface_of(bsdf)
    if surface is not None:
        found = surface.under(coat)
        return bsdf if found is surface else bsdf_of(found)
    name = bsdf.class_name()
    if name == "RoughConductor":
        return _conductor_below(bsdf, coat)
    if name == "TwoSidedBRDF":
        front = nested_objects(bsdf)["brdf_0"]
        inside = below(front, coat)
        return bsdf if inside is front else inside
    return _wrapper_below(bsdf, coat) if name in WRAPPERS else bsdf


def _nested(bsdf: "mi.BSDF") -> dict[str, "mi.BSDF"]:
    parts = nested_objects(bsdf)
    return {name: part for name, part in parts.items() if isinstance(part, mi.BSDF)}


def _wrapper_below(wrapper: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """One of `WRAPPERS` around its nested BSDFs below a medium; itself if they stay the same."""
    nested = _nested(wrapper)
    changed = {id(bsdf): below(bsdf, coat) for bsdf in nested.values()}
    if all(changed[id(bsdf)] is bsdf for bsdf in nested.values()):
        return wrapper
    given = nested_objects(wrapper) | {"type": WRAPPERS[wrapper.class_name()]}
    if given["type"] == "bumpmap":
        given["scale"] = mi.traverse(wrapper)["scale"]
    if given["type"] in NORMALS.values():
        given |= _switches(wrapper, given)
    return mi.load_dict(given | {name: changed[id(bsdf)] for name, bsdf in nested.items()})


def _switches(wrapper: "mi.BSDF", given: dict[str, Any]) -> dict[str, bool]:
    """The switches of a `normalmap` or `bumpmap`, which it does not list among its parameters.

    They are those with which it reflects as it does.

    given: its properties without them.
    """
    rng = np.random.default_rng(0)
    pairs = *cosine_pairs(rng, SWITCH_PAIRS), rng.random((SWITCH_PAIRS, 2))
    f = probing.bsdf_values(wrapper, *pairs)
    for on in itertools.product((True, False), repeat=len(SWITCHES)):
        switches = dict(zip(SWITCHES, on, strict=True))
        found = probing.bsdf_values(mi.load_dict(given | switches), *pairs)
        if np.allclose(found, f, rtol=1e-3):
            break
    return switches


def _conductor_below(conductor: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """A `roughconductor` of indices relative to a medium."""

    def relative(si, active, index):
        return index / coat.inside(si, active)

    parts, text = nested_objects(conductor), str(conductor)
    given = {name: derived(relative, {name: parts[name]}, coat) for name in ("eta", "k")}
    given["distribution"] = "ggx" if GGX in text else "beckmann"
    given["sample_visible"] = "sample_visible = 0" not in text
    return mi.load_dict({"type": "roughconductor"} | parts | given)


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


class LowestInterface:
    """The surface of a body of glass under coats: a `roughdielectric` or a `dielectric`."""

    DRJIT_STRUCT: ClassVar = {"textures": dict, "index": object}  # for frozen functions

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
