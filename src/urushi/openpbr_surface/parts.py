"""Parts of a material that are plugins of their own, and their properties by its parameters."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mitsuba as mi

from urushi.core.appearance import optical_depth
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba.reading.changed import derived as from_textures
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs, clipped

#: Plugins of coats: by tables or codes, and by walks.
COATS = ("neural_layered", "layered")


class Coating(NamedTuple):
    """How coats and slabs are computed."""

    tables: bool  # whether by tables or codes; else by walks
    options: dict[str, Any]  # weights and resolution of the tables, if given
    compensated: bool  # whether energy that they lose is compensated


def load_part(inputs: Inputs, description: dict[str, Any]) -> "mi.BSDF":
    """Load a part of a material, whose errors begin with the plugin that the user wrote."""
    try:
        return mi.load_dict(description | {"origin": inputs.where})
    except RuntimeError as error:
        last = str(error).strip().splitlines()[-1]
        _, found, cause = last.partition(inputs.where + ": ")
        if not found:
            _, found, cause = last.partition("ParameterError: ")
        if not found:
            raise
        walk = ", which openpbr takes by the option 'reference'" if "'layered'" in cause else ""
        raise ParameterError(f"{inputs.where}: {cause}{walk}") from error


def derived(
    inputs: Inputs, names: Sequence[str], function: Callable[..., Any], *, color: bool = False
) -> "mi.Texture":
    """A texture whose value is a function of the parameters `names`, in order.

    function: of Dr.Jit floats; color: of spectra.
    """

    def within_ranges(si: Any, active: Any, *values: Any) -> Any:
        return function(*map(clipped, names, values))

    sources = {name: inputs.textures[name] for name in names}
    return from_textures(within_ranges, sources, color=color)


def width_properties(inputs: Inputs, layer: str) -> dict[str, "mi.Texture"]:
    """GGX widths as properties of Mitsuba's plugins; layer: "coat" or "specular"."""
    names = f"{layer}_roughness", f"{layer}_roughness_anisotropy"
    if inputs.is_constant(names[1], 0):
        return {"alpha": derived(inputs, names[:1], lambda r: formulas.lobe_width(r, DRJIT))}
    return {
        name: derived(inputs, names, lambda r, a, i=i: formulas.lobe_widths(r, a, DRJIT)[i])
        for i, name in enumerate(("alpha_u", "alpha_v"))
    }


def coat_properties(inputs: Inputs) -> dict[str, Any]:
    """The coat as properties of a plugin, without its type and what lies below."""
    index = derived(inputs, ("coat_ior",), lambda ior: formulas.interface_index(ior, DRJIT))
    coat = {"ext_ior": 1.0, "int_ior": index, **width_properties(inputs, "coat")}
    return coat | absorption(inputs, "coat_color", 1)


def absorption(inputs: Inputs, name: str, depths: int) -> dict[str, Any]:
    """The medium of a plugin by the colour of light that crosses it; none if it is white.

    depths: number of the optical depths of a coat of this colour.
    """
    if inputs.is_constant(name, 1):
        return {}

    def depth(color: Any) -> Any:
        return depths * optical_depth(color, DRJIT)

    return {"sigma_t": derived(inputs, (name,), depth, color=True)}
