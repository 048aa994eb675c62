"""Shares of a surface that transmits light, and what they have in common."""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parts import derived

#: The parameters on which the shares depend.
SHARES = ("base_metalness", "transmission_weight", "subsurface_weight")

#: The parameters on which the index of a body depends.
INDICES = ("specular_ior", "specular_weight")


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

    def metal(*of: Any) -> Any:
        return of[0] / DRJIT.maximum(shares(*of).opaque, 1e-6)

    value = derived(inputs, SHARES, metal) if share is None else known[0] / share
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
    ior = float(formulas.modulated_index(max(ior, formulas.LEAST_INDEX), weight))
    if inputs.thin:  # a slab
        return float(formulas.interface_index(ior))
    return min(max(ior, 1 / 3), 3.0)


def index2(w, index):
    """The square of the index on the side of a direction."""
    return dr.select(w.z > 0, 1, index * index)


def tint_of(inputs: Inputs, si, active) -> Any:
    """The factor of light that crosses the base's interface, without a transmission_depth."""
    if not inputs.transmits(SHARES[1]) or not inputs.is_constant("transmission_depth", 0):
        return mi.Spectrum(1)
    color = inputs.color("transmission_color", si, active)
    found = shares(*(inputs.number(name, si, active) for name in SHARES))
    return dr.lerp(color, 1, found.scattering / dr.maximum(found.transmitting, 1e-6))
