"""Mitsuba BSDFs below the medium of a coat: indices of refraction become relative to it."""

import itertools
from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.derived import derived
from urushi.mitsuba.reading.grid import NORMALS, nested_objects
from urushi.mitsuba.reading.known import GGX
from urushi.mitsuba.recording import Recorded
from urushi.mitsuba.surface import bsdf_of, surface_of

#: Classes of Mitsuba's BSDFs that reflect as the BSDFs nested in them, and their plugins.
WRAPPERS = NORMALS | {"BlendBSDF": "blendbsdf"}

#: Properties of `normalmap` and `bumpmap` that they do not list, by default true, and the number of
#: pairs at which they are found.
SWITCHES, SWITCH_PAIRS = ("use_shadowing_function", "flip_invalid_normals"), 1024


class Medium(Recorded):
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


def relative_to_index(bsdf: "mi.BSDF", index: npt.ArrayLike) -> "mi.BSDF":
    """A BSDF below a medium of an index relative to air; see `urushi.walk.stack.under`."""
    return relative_to(bsdf, Medium(index))


def relative_to(bsdf: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """A BSDF as it reflects below the medium of a coat, `CoatTextures` or a `Medium`.

    Coats without `ext_ior`, and saved materials that were layered, keep their absolute indices. The
    index of a `roughconductor` is divided by the medium's, relative to air. So it is for those
    within Mitsuba's `twosided`, `blendbsdf`, `normalmap` and `bumpmap`. All others, such as
    measured BRDFs, are as they are in air.
    """
    surface = surface_of(bsdf)
    if surface is not None:
        found = surface.relative_to(coat)
        return bsdf if found is surface else bsdf_of(found)
    name = bsdf.class_name()
    if name == "RoughConductor":
        return _conductor_relative(bsdf, coat)
    if name == "TwoSidedBRDF":
        front = nested_objects(bsdf)["brdf_0"]
        inside = relative_to(front, coat)
        return bsdf if inside is front else inside
    return _wrapper_relative(bsdf, coat) if name in WRAPPERS else bsdf


def _nested(bsdf: "mi.BSDF") -> dict[str, "mi.BSDF"]:
    parts = nested_objects(bsdf)
    return {name: part for name, part in parts.items() if isinstance(part, mi.BSDF)}


def _wrapper_relative(wrapper: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """One of `WRAPPERS` around its nested BSDFs below a medium; itself if they stay the same."""
    nested = _nested(wrapper)
    changed = {id(bsdf): relative_to(bsdf, coat) for bsdf in nested.values()}
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


def _conductor_relative(conductor: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """A `roughconductor` of indices relative to a medium."""

    def relative(si, active, index):
        return index / coat.inside(si, active)

    parts, text = nested_objects(conductor), str(conductor)
    given = {name: derived(relative, {name: parts[name]}, coat) for name in ("eta", "k")}
    given["distribution"] = "ggx" if GGX in text else "beckmann"
    given["sample_visible"] = "sample_visible = 0" not in text
    return mi.load_dict({"type": "roughconductor"} | parts | given)
