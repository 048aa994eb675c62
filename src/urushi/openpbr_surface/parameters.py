"""The parameters of OpenPBR Surface 1.1.1: names, kinds, ranges and defaults.

From the specification's tables (Andersson et al., OpenPBR Surface 1.1.1) and its reference graph
`open_pbr_surface.mtlx`. The order is the reference graph's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from urushi.checks import NO_NUMBERS, Check, real
from urushi.errors import ParameterError, choice

#: A number; a linear colour; a truth value; a direction, which a map or the geometry gives.
Kind = Literal["float", "color", "boolean", "vector"]


@dataclass(frozen=True)
class Parameter:
    """A parameter of the specification."""

    name: str
    kind: Kind
    default: float | tuple[float, float, float] | bool | None  # None: the geometry's own direction
    low: float  # of the values that are allowed, ends included
    high: float
    description: str  # one sentence, with the unit if there is one


_INF = np.inf
_WHITE = (1.0, 1.0, 1.0)
_GREY = (0.8, 0.8, 0.8)

#: All parameters by name.
PARAMETERS: dict[str, Parameter] = {
    row[0]: Parameter(*row)
    for row in (
        ("base_weight", "float", 1.0, 0, 1, "Multiplier of base_color."),
        ("base_color", "color", _GREY, 0, 1, "Albedo of the diffuse base; a metal's F0."),
        ("base_diffuse_roughness", "float", 0.0, 0, 1, "Roughness of the diffuse base (EON)."),
        ("base_metalness", "float", 0.0, 0, 1, "Share of the base that is metal."),
        ("specular_weight", "float", 1.0, 0, _INF, "Multiplier of the base's reflectivity."),
        ("specular_color", "color", _WHITE, 0, 1, "Tint of a dielectric's highlight; of F82."),
        ("specular_roughness", "float", 0.3, 0, 1, "Roughness of the base's interface."),
        ("specular_ior", "float", 1.5, 0, _INF, "Index of refraction of the dielectric base."),
        ("specular_roughness_anisotropy", "float", 0.0, 0, 1, "Anisotropy of that interface."),
        ("transmission_weight", "float", 0.0, 0, 1, "Share of the base that transmits."),
        ("transmission_color", "color", _WHITE, 0, 1, "Colour at transmission_depth."),
        ("transmission_depth", "float", 0.0, 0, _INF, "Length at which it is reached."),
        ("transmission_scatter", "color", (0.0, 0.0, 0.0), 0, 1, "Scattering in the interior."),
        ("transmission_scatter_anisotropy", "float", 0.0, -1, 1, "Its Henyey-Greenstein g."),
        ("transmission_dispersion_scale", "float", 0.0, 0, 1, "Amount of dispersion."),
        ("transmission_dispersion_abbe_number", "float", 20.0, 0, _INF, "The Abbe number."),
        ("subsurface_weight", "float", 0.0, 0, 1, "Share of the opaque base that scatters."),
        ("subsurface_color", "color", _GREY, 0, 1, "Albedo of the scattering base."),
        ("subsurface_radius", "float", 1.0, 0, _INF, "Mean free path of its medium."),
        ("subsurface_radius_scale", "color", (1.0, 0.5, 0.25), 0, 1, "Factor per channel."),
        ("subsurface_scatter_anisotropy", "float", 0.0, -1, 1, "Its Henyey-Greenstein g."),
        ("fuzz_weight", "float", 0.0, 0, 1, "Share of the surface that fuzz covers."),
        ("fuzz_color", "color", _WHITE, 0, 1, "Colour of the fuzz."),
        ("fuzz_roughness", "float", 0.5, 0, 1, "Roughness of the fuzz."),
        ("coat_weight", "float", 0.0, 0, 1, "Share of the surface that the coat covers."),
        ("coat_color", "color", _WHITE, 0, 1, "Square of its transmittance at the normal."),
        ("coat_roughness", "float", 0.0, 0, 1, "Roughness of the coat's interface."),
        ("coat_roughness_anisotropy", "float", 0.0, 0, 1, "Anisotropy of that interface."),
        ("coat_ior", "float", 1.6, 0, _INF, "Index of refraction of the coat."),
        ("coat_darkening", "float", 1.0, 0, 1, "Share of the darkening by the coat that is kept."),
        ("thin_film_weight", "float", 0.0, 0, 1, "Share of the base that the film covers."),
        ("thin_film_thickness", "float", 0.5, 0, _INF, "Thickness of the film [micrometres]."),
        ("thin_film_ior", "float", 1.4, 0, _INF, "Index of refraction of the film."),
        ("emission_luminance", "float", 0.0, 0, _INF, "Luminance of emitted light [nit]."),
        ("emission_color", "color", _WHITE, 0, _INF, "Multiplier of that luminance."),
        ("geometry_opacity", "float", 1.0, 0, 1, "Opacity of the whole surface."),
        ("geometry_thin_walled", "boolean", False, -_INF, _INF, "Whether it is a thin sheet."),
        ("geometry_normal", "vector", None, -_INF, _INF, "Normal of the base."),
        ("geometry_coat_normal", "vector", None, -_INF, _INF, "Normal of the coat."),
        ("geometry_tangent", "vector", None, -_INF, _INF, "Tangent of the base's anisotropy."),
        ("geometry_coat_tangent", "vector", None, -_INF, _INF, "Tangent of the coat's anisotropy."),
    )
}


def names_of(*groups: str) -> tuple[str, ...]:
    """The numbers and colours of groups, the beginnings of names: "coat", "thin_film"."""
    begins = tuple(f"{group}_" for group in groups)
    found = [x for x in PARAMETERS.values() if x.kind in ("float", "color")]
    return tuple(entry.name for entry in found if entry.name.startswith(begins))


#: The parameters of emission, which a BSDF does not have.
EMISSION = names_of("emission")


def parameter(name: str, where: str = "openpbr", others: Sequence[str] = ()) -> Parameter:
    """The parameter of a name; others: names that an error may suggest as well."""
    if name in PARAMETERS:
        return PARAMETERS[name]
    names = (*PARAMETERS, *others)
    raise ParameterError(f"{where}: there is no parameter '{name}'; {choice(name, names)}")


def checked(name: str, value: Any, where: str = "openpbr") -> Any:
    """A constant value of a parameter, after checks of its kind and range.

    value: a number; for a colour a number or three.

    Returns:
        A float, a float64 array of shape (3,), or a bool. -0.0 becomes 0.0.
    """
    entry = parameter(name, where)
    if entry.kind == "boolean":
        if np.ndim(value) == 0 and value in (0, 1):
            return bool(value)
        raise ParameterError(f"{where}: {name} is {value!r}; give true or false")
    if entry.kind == "vector":
        raise ParameterError(
            f"{where}: {name} cannot be a constant; give it as a normal map, or leave it out"
        )
    try:
        array = real(value, np.float64)
    except NO_NUMBERS:
        array = np.empty((0,))
    shapes = ((), (3,)) if entry.kind == "color" else ((),)
    if array.shape not in shapes:
        expected = "a number or three, one per RGB channel" if entry.kind == "color" else "a number"
        raise ParameterError(f"{where}: {name} is {value!r}; give {expected}")
    low, high = entry.low, entry.high
    limits = f"in [{low:g}, {high:g}]" if high < _INF else f"finite and {low:g} or more"
    array = Check(name, limits, low, high)(array, f"{where}: {name}")
    return float(array) if entry.kind == "float" else np.broadcast_to(array, 3)


def complete(values: Mapping[str, Any], where: str = "openpbr") -> dict[str, Any]:
    """All parameters but the directions: constants that are given, checked, and the defaults."""
    for name in values:
        parameter(name, where)
    return {
        name: checked(name, values.get(name, entry.default), where)
        for name, entry in PARAMETERS.items()
        if entry.kind != "vector"
    }
