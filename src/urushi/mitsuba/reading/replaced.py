"""BSDFs with other textures and numbers in the place of some of their own."""

from collections.abc import Callable, Mapping
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.reading.known import GGX
from urushi.mitsuba.surface import surface_of

#: From a texture to the one that replaces it, maybe itself.
Replacement = Callable[["mi.Texture"], "mi.Texture"]

#: Plugins by class. Of Mitsuba's, with the properties of the numbers that `mi.traverse` lists.
PLUGINS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "SmoothDiffuse": ("diffuse", {}),
    "RoughConductor": ("roughconductor", {}),
    "RoughPlastic": ("roughplastic", {"alpha": "alpha", "eta": "int_ior"}),
    "PolarizedPlastic": ("pplastic", {"alpha": "alpha", "eta": "int_ior"}),
    "Principled": ("principled", {"eta": "eta", "specular": "specular"}),
    "BlendBSDF": ("blendbsdf", {}),
}

#: The line of a `roughplastic`'s description that says it is nonlinear.
NONLINEAR = "nonlinear = 1"


def parts(bsdf: "mi.BSDF") -> dict[str, "mi.Object"]:
    """The objects nested in a BSDF by their names; of those nested in it, "name.name"."""
    found = {}
    for name, part in nested_objects(bsdf).items():
        found[name] = part
        if isinstance(part, mi.BSDF):
            found |= {f"{name}.{inner}": x for inner, x in parts(part).items()}
    return found


def numbers_of(bsdf: "mi.Object") -> Mapping[str, str]:
    """The plain numbers that `mi.traverse` lists of a BSDF, and the properties that give them."""
    return PLUGINS.get(bsdf.class_name(), ("", {}))[1]


def replaced(
    bsdf: "mi.BSDF",
    replacement: Replacement,
    numbers: Mapping[str, float] | None = None,
) -> "mi.BSDF | None":
    """The BSDF with other textures; None: it is of an unknown kind.

    numbers: other numbers by the names of `mi.traverse`.
    """
    surface = surface_of(bsdf)
    if surface is not None:
        return surface.replaced(replacement)
    if bsdf.class_name() == "TwoSidedBRDF":
        front = nested_objects(bsdf)["brdf_0"]
        return replaced(front, replacement, _inside(numbers, "brdf_0"))
    if bsdf.class_name() not in PLUGINS:
        return None
    plugin, listed = PLUGINS[bsdf.class_name()]
    given: dict[str, Any] = {"type": plugin}
    for name, part in nested_objects(bsdf).items():
        if isinstance(part, mi.BSDF):
            given[name] = replaced(part, replacement, _inside(numbers, name))
            if given[name] is None:
                return None
        else:
            given[name] = replacement(part)
    parameters = mi.traverse(bsdf)
    for key, name in listed.items():
        if key in parameters and key not in given:
            given[name] = float(np.ravel(parameters[key])[0])
            if numbers and key in numbers:
                given[name] = numbers[key]
    if "int_ior" in given:
        given["ext_ior"] = 1.0
    if plugin == "roughplastic":
        given["nonlinear"] = NONLINEAR in str(bsdf)
    if "distribution = " in str(bsdf) and plugin != "blendbsdf":
        given["distribution"] = "ggx" if GGX in str(bsdf) else "beckmann"
    return mi.load_dict(given)


def _inside(numbers: Mapping[str, float] | None, name: str) -> dict[str, float]:
    """Of numbers by name, those of a nested part."""
    start = name + "."
    given = numbers or {}
    return {key.removeprefix(start): x for key, x in given.items() if key.startswith(start)}
