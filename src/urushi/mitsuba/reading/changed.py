"""Mitsuba's BSDFs with other parts: with other textures, or below the medium of a coat."""

import itertools
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import NORMALS, nested_objects
from urushi.mitsuba.reading.parameters import Medium
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


def derived(
    function: Callable[..., Any],
    sources: Mapping[str, "mi.Texture"],
    medium: Medium | None = None,
    *,
    color: bool = True,
) -> "mi.Texture":
    """A texture whose value is a function of a surface interaction, lanes, and values of sources.

    sources: by the names that `mi.traverse` lists. medium: whose index the function depends on,
    too. color: whether `eval` reads the sources' spectra, not numbers.
    """
    return _derived_class(mi.variant())(function, sources, medium, color)


@cache
def _derived_class(variant: str) -> type:
    """The class in a variant."""

    class Derived(mi.Texture):
        def __init__(self, function, sources, medium, color):
            self._function, self.sources = function, dict(sources)
            self._medium, self._color = medium, color
            mi.Texture.__init__(self, mi.Properties("derived"))

        def eval(self, si, active=True):
            if not self._color:
                return mi.Spectrum(self.eval_1(si, active))
            values = [x.eval(si, active) for x in self.sources.values()]
            return mi.Spectrum(self._function(si, active, *values))

        def eval_1(self, si, active=True):
            values = [x.eval_1(si, active) for x in self.sources.values()]
            return self._function(si, active, *values)

        def mean(self):
            return self._function(None, True, *(x.mean() for x in self.sources.values()))

        def is_spatially_varying(self):
            return False  # the sources are listed and vary by themselves, with their own transforms

        def traverse(self, callback):
            for name, source in self.sources.items():
                callback.put(name, source, mi.ParamFlags.Differentiable)
            if self._medium is not None:
                self._medium.put_index(callback)

        def to_string(self):
            return f"Derived[{', '.join(self.sources)}]"

    return Derived


def relative_to_index(bsdf: "mi.BSDF", index: npt.ArrayLike) -> "mi.BSDF":
    """A BSDF below a medium of an index relative to air; see `urushi.walk.stack.under`."""
    return relative_to(bsdf, Medium(index))


def relative_to(bsdf: "mi.BSDF", medium: Medium) -> "mi.BSDF":
    """A BSDF as it reflects below a medium, maybe that of a coat.

    Coats without `ext_ior`, and saved materials that were layered, keep their absolute indices. The
    index of a `roughconductor` is divided by the medium's, relative to air. So it is for those
    within Mitsuba's `twosided`, `blendbsdf`, `normalmap` and `bumpmap`. All others, such as
    measured BRDFs, are as they are in air.
    """
    surface, name = surface_of(bsdf), bsdf.class_name()
    if surface is not None:
        found = surface.relative_to(medium)
        return bsdf if found is surface else bsdf_of(found)
    if name not in ("RoughConductor", "TwoSidedBRDF", "BlendBSDF", *NORMALS):
        return bsdf

    def below(key: str, part: "mi.Object") -> "mi.Object":
        if isinstance(part, mi.BSDF):
            return relative_to(part, medium)
        if name == "RoughConductor" and key in ("eta", "k"):
            return derived(lambda si, on, x: x / medium.inside(si, on), {key: part}, medium)
        return part

    parts = nested_objects(bsdf)
    inside = {key: below(key, part) for key, part in parts.items()}
    if all(inside[key] is part for key, part in parts.items()):
        return bsdf
    if name == "TwoSidedBRDF":
        return inside["brdf_0"]
    return _rebuilt(bsdf, inside, _switches(bsdf) if name in NORMALS else {})


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
    if name != "TwoSidedBRDF" and (name not in PLUGINS or name in NORMALS):
        return None
    given, parts = numbers or {}, dict[str, Any]()
    for key, part in nested_objects(bsdf).items():
        if isinstance(part, mi.BSDF):
            start = key + "."
            inner = {k.removeprefix(start): x for k, x in given.items() if k.startswith(start)}
            parts[key] = replaced(part, replacement, inner)
        else:
            parts[key] = replacement(part)
    if name == "TwoSidedBRDF":
        return parts["brdf_0"]
    if None in parts.values():
        return None
    return _rebuilt(bsdf, parts, {key: x for key, x in given.items() if "." not in key})


def _rebuilt(
    bsdf: "mi.BSDF", parts: Mapping[str, "mi.Object"], others: Mapping[str, Any]
) -> "mi.BSDF":
    """A BSDF of one of `PLUGINS` with other parts.

    Args:
        parts: by the names of those that they replace.
        others: numbers by the names of `mi.traverse`, and properties that it does not list.
    """
    plugin, listed = PLUGINS[bsdf.class_name()]
    parameters, text, others = mi.traverse(bsdf), str(bsdf), dict(others)
    given: dict[str, Any] = dict(parts)
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
        found = _rebuilt(wrapper, nested_objects(wrapper), switches)
        if np.allclose(probing.bsdf_values(found, *pairs), f, rtol=1e-3):
            break
    return switches
