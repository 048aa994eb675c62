"""Parts of a material: their shares, and plugins with properties by its parameters."""

from collections.abc import Callable, Container, Sequence
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.appearance import optical_depth
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba.reading.changed import derived as from_textures
from urushi.mitsuba.surface import Surface
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs, Values, clipped

#: Plugins of coats: by tables or codes, and by walks.
COATS = ("neural_layered", "layered")

#: The parameters on which the shares depend.
SHARES = ("base_metalness", "transmission_weight", "subsurface_weight")

#: The parameters on which the index of a body depends.
INDICES = ("specular_ior", "specular_weight")


class Coating(NamedTuple):
    """How coats and slabs are computed."""

    tables: bool  # whether by tables or codes; else by walks
    options: dict[str, Any]  # weights and resolution of the tables, if given
    compensated: bool  # whether energy that they lose is compensated


class OfInputs(Surface):
    """A surface of parameters."""

    names: tuple[str, ...]  # the parameters that it reads
    fixed: Container[str] = ()  # those of them by which it has no derivatives

    def __init__(self, inputs: Inputs, coating: Any = None):
        """coating: a `Coating`, of what may have a coat."""
        self._inputs, self._coating = inputs, coating
        self._configure()
        super().__init__(mi.Properties("openpbr"), inputs.where)

    def _configure(self) -> None:
        """Make what the parameters need."""

    def traverse(self, callback):
        self._inputs.traverse(callback, self.names, self.fixed)


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
    sources = {name: inputs.textures[name] for name in names}
    return from_textures(
        lambda si, active, *values: function(*map(clipped, names, values)), sources, color=color
    )


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
    texture = derived(inputs, (name,), lambda x: depths * optical_depth(x, DRJIT), color=True)
    return {"sigma_t": texture}


class Shares(NamedTuple):
    """Shares of the surface: what is opaque, clear, and scatters light below it."""

    opaque: Any
    clear: Any
    scattering: Any

    @property
    def transmitting(self) -> Any:
        """The share that is not opaque."""
        return self.clear + self.scattering


def shares(metal: Any, clear: Any, scattering: Any) -> Shares:
    """The shares of `SHARES`, numbers or arrays."""
    rest = (1 - metal) * (1 - clear)
    return Shares(metal + rest * (1 - scattering), (1 - metal) * clear, rest * scattering)


def transmits(inputs: Inputs) -> bool:
    """Whether a part of the surface is seen from both sides."""
    return inputs.thin or any(inputs.transmits(name) for name in SHARES[1:])


def opaque_share(inputs: Inputs) -> Inputs | None:
    """The parameters of the opaque share alone; None if there is none."""
    known = [inputs.known(name) for name in SHARES]
    share = None if None in known else shares(*known).opaque
    if share == 0:
        return None
    of_shares = SHARES, lambda *x: x[0] / dr.maximum(shares(*x).opaque, 1e-6)
    value = derived(inputs, *of_shares) if share is None else known[0] / share
    return inputs.replaced({"base_metalness": value, **dict.fromkeys(SHARES[1:], 0.0)})


def without_medium(inputs: Inputs) -> Inputs:
    """The parameters for a body of no depth: each colour of its medium is one of its surface.

    Light that is scattered below the surface leaves where it entered: subsurface_color is the
    albedo of a diffuse base. transmission_color tints the light that crosses the surface.
    """
    names = "base_weight", "base_color", "subsurface_weight", "subsurface_color"
    color = derived(inputs, names, lambda w, b, s, c: dr.lerp(w * b, c, s), color=True)
    changed = {"transmission_depth": 0.0}
    if inputs.transmits("subsurface_weight"):
        changed |= {"base_color": color, "base_weight": 1.0, "subsurface_weight": 0.0}
    return inputs.replaced(changed)


def index_of(inputs: Inputs) -> float:
    """The index of the base relative to air.

    Raises:
        ParameterError: it varies.
    """
    for name in INDICES:
        if not inputs.is_uniform(name):
            raise ParameterError(
                f"{inputs.where}: {name} is a texture, but what transmits light needs one index; "
                "give a number"
            )
    ior, weight = (inputs.middle(name) for name in INDICES)
    index = formulas.base_index(ior, 1.0, 0.0, weight)
    return float(formulas.interface_index(index) if inputs.thin else index)  # thin: a slab


def index2(w, index):
    """The square of the index on the side of a direction."""
    return dr.select(w.z > 0, 1, index * index)


def tint_of(inputs: Inputs, at: Values) -> Any:
    """The factor of light that crosses the base's interface, without a transmission_depth."""
    if not inputs.transmits(SHARES[1]) or not inputs.is_constant("transmission_depth", 0):
        return mi.Spectrum(1)
    found = shares(*at.of(*SHARES))
    untinted = found.scattering / dr.maximum(found.transmitting, 1e-6)
    return dr.lerp(at.transmission_color, 1, untinted)
