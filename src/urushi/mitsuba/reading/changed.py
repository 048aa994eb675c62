"""Mitsuba's BSDFs with other parts: with other textures, or below the medium of a coat."""

import itertools
from collections.abc import Callable, Mapping
from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import NORMALS, nested_objects
from urushi.mitsuba.reading.textures import derived
from urushi.mitsuba.recording import Recorded
from urushi.mitsuba.surface import bsdf_of, surface_of

#: Plugins by class, with the properties of the numbers that `mi.traverse` lists.
PLUGINS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "SmoothDiffuse": ("diffuse", {}),
    "RoughConductor": ("roughconductor", {}),
    "RoughPlastic": ("roughplastic", {"alpha": "alpha", "eta": "int_ior"}),
    "PolarizedPlastic": ("pplastic", {"alpha": "alpha", "eta": "int_ior"}),
    "Principled": ("principled", {"eta": "eta", "specular": "specular"}),
    "BlendBSDF": ("blendbsdf", {}),
    "NormalMap": ("normalmap", {}),
    "BumpMap": ("bumpmap", {"scale": "scale"}),
}

#: The line of a `roughplastic`'s description that says it is nonlinear.
NONLINEAR = "nonlinear = 1"

#: Switches of `normalmap` and `bumpmap`, true by default. Descriptions of these plugins leave them
#: out, so that they are found from f at this many pairs.
SWITCHES, SWITCH_PAIRS = ("use_shadowing_function", "flip_invalid_normals"), 1024


def numbers_of(bsdf: "mi.Object") -> Mapping[str, str]:
    """The plain numbers that `mi.traverse` lists of a BSDF, and the properties that give them."""
    return PLUGINS.get(bsdf.class_name(), ("", {}))[1]


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
    surface, name = surface_of(bsdf), bsdf.class_name()
    if surface is not None:
        found = surface.relative_to(coat)
        return bsdf if found is surface else bsdf_of(found)
    if name == "RoughConductor":

        def relative(si, active, index):
            return index / coat.inside(si, active)

        def below(name: str, part: "mi.Object") -> "mi.Object":
            return derived(relative, {name: part}, coat) if name in ("eta", "k") else part

        return _rebuilt(bsdf, below)
    if name == "TwoSidedBRDF":
        front = nested_objects(bsdf)["brdf_0"]
        inside = relative_to(front, coat)
        return bsdf if inside is front else inside
    if name != "BlendBSDF" and name not in NORMALS:
        return bsdf
    nested = {id(x): x for x in nested_objects(bsdf).values() if isinstance(x, mi.BSDF)}
    inside = {key: relative_to(part, coat) for key, part in nested.items()}
    if all(part is nested[key] for key, part in inside.items()):
        return bsdf
    switches = _switches(bsdf) if name in NORMALS else {}
    return _rebuilt(bsdf, lambda name, part: inside.get(id(part), part), switches)


def replaced(
    bsdf: "mi.BSDF",
    replacement: Callable[["mi.Texture"], "mi.Texture"],
    numbers: Mapping[str, float] | None = None,
) -> "mi.BSDF | None":
    """The BSDF with other textures; None: it is of an unknown kind.

    Args:
        replacement: from a texture to the one that replaces it, maybe itself.
        numbers: other numbers by the names of `mi.traverse`.
    """
    surface, name = surface_of(bsdf), bsdf.class_name()
    if surface is not None:
        return surface.replaced(replacement)
    given = numbers or {}

    def change(name: str, part: "mi.Object") -> "mi.Object | None":
        if not isinstance(part, mi.BSDF):
            return replacement(part)
        start = name + "."
        inner = {key.removeprefix(start): x for key, x in given.items() if key.startswith(start)}
        return replaced(part, replacement, inner)

    if name == "TwoSidedBRDF":
        return change("brdf_0", nested_objects(bsdf)["brdf_0"])
    if name not in PLUGINS or name in NORMALS:
        return None
    return _rebuilt(bsdf, change, {key: x for key, x in given.items() if "." not in key})


def _rebuilt(bsdf: "mi.BSDF", change: Callable, others: Mapping[str, Any] | None = None) -> Any:
    """A BSDF of one of `PLUGINS` with other parts; None: one of them is None.

    Args:
        change: from the name of a part and the part to the other one.
        others: numbers by the names of `mi.traverse`, and properties that it does not list.
    """
    plugin, listed = PLUGINS[bsdf.class_name()]
    parameters, text, others = mi.traverse(bsdf), str(bsdf), dict(others or {})
    given = {name: change(name, part) for name, part in nested_objects(bsdf).items()}
    if None in given.values():
        return None
    for key, name in listed.items():
        if key in parameters and key not in given:
            given[name] = others.pop(key, float(np.ravel(parameters[key])[0]))
    if "int_ior" in given:
        given["ext_ior"] = 1.0
    if "alpha" in given or "alpha_u" in given:
        given["distribution"] = "ggx" if probing.GGX in text else "beckmann"
        given["sample_visible"] = "sample_visible = 0" not in text
    if plugin == "roughplastic":
        given["nonlinear"] = NONLINEAR in text
    return mi.load_dict({"type": plugin, **given, **others})


def _switches(wrapper: "mi.BSDF") -> Mapping[str, Any]:
    """The switches with which a `normalmap` or `bumpmap` reflects as it does."""
    rng = np.random.default_rng(0)
    pairs = *cosine_pairs(rng, SWITCH_PAIRS), rng.random((SWITCH_PAIRS, 2))
    f = probing.bsdf_values(wrapper, *pairs)
    for on in itertools.product((True, False), repeat=len(SWITCHES)):
        switches = dict(zip(SWITCHES, on, strict=True))
        found = _rebuilt(wrapper, lambda name, part: part, switches)
        if np.allclose(probing.bsdf_values(found, *pairs), f, rtol=1e-3):
            break
    return switches
