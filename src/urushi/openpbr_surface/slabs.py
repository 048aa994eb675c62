"""Panes, and coats on what transmits light, as slabs of `layered` and `neural_layered`."""

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.checks import AIR
from urushi.core.namespace import DRJIT
from urushi.mitsuba.frames import SlabMixture, raised, relative
from urushi.mitsuba.reading.nested import DECIMALS
from urushi.mitsuba.recording import opaque
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.bsdfs import SPREAD, SurfaceProposal
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.lost_light import AXES, LostLight, Place
from urushi.openpbr_surface.parts import absorption, coat_properties, width_properties
from urushi.openpbr_surface.shares import index2, index_of, tint_of
from urushi.walk import interface


class Finish:
    """What a part lacks: the tint of a coated body, and light that meets more than one facet.

    The lobe that returns the light is as that of `Glass`.
    """

    def __init__(self, inputs: Inputs, coated: bool, white: Callable[..., Any] | None):
        """white: makes the white slab, with some parameters replaced; None: it loses no light."""
        self._inputs, self._coated = inputs, coated
        self._index = opaque(1.0 if inputs.thin else index_of(inputs))
        self._losses: LostLight | None = None
        if white is not None:
            layers = ("specular", "coat") if coated else ("specular",)
            names = [name for name in AXES if name.split("_")[0] in layers]
            self._losses = LostLight(inputs, names, layers, white)

    def _scale(self, losses: LostLight, place: Place) -> tuple[Any, Any]:
        """The scale of the lobe, and the share of the light that is returned below."""
        _, above, _, below = losses.means(place)
        below = dr.pi * self._index * self._index * below
        scale = dr.maximum(dr.pi * above + below, 1e-5)
        return scale, below / scale

    def _returned(self, losses: LostLight, si, active):
        """Directions of the returned light, and their share of all."""
        place = losses.at(si, active)
        below = self._scale(losses, place)[1]
        through = dr.select(si.wi.z > 0, below, 1 - below)
        share = dr.clip(losses.lost(si.wi, place), 0, 0.9)
        return SlabMixture(SPREAD, SPREAD, 1 - through, 1.0), share

    def proposal(self, slab, si, active):
        """The proposal of the slab with it."""
        if self._losses is None:
            return slab
        lobe, share = self._returned(self._losses, si, active)
        return SurfaceProposal([(slab, 1 - share), (lobe, share)])

    def density(self, density, si, wo, active):
        """The density of `proposal` at wo, from the slab's [1/sr]."""
        if self._losses is None:
            return density
        lobe, share = self._returned(self._losses, si, active)
        return dr.lerp(density, lobe.pdf(si.wi, wo), share)

    def f(self, f, ctx, si, wo, active):
        """f [1/sr] of the slab with it."""
        inputs, through = self._inputs, si.wi.z * wo.z < 0
        tint = tint_of(inputs, si, active)
        if self._coated and not inputs.thin:
            # Light from below that the surface of the body does not reflect crosses it twice.
            coat = formulas.interface_index(inputs.number("coat_ior", si, active), DRJIT)
            a, b = raised(si.wi), relative(si.wi, wo)
            widths = inputs.widths("specular", si, active)
            first = interface.reflection(a, b, widths, coat / self._index)
            below = (si.wi.z < 0) & ~through
            f = dr.select(below, first + tint * tint * (f - first), f * dr.select(through, tint, 1))
        if self._losses is None:
            return f
        place = self._losses.at(si, active)
        one, other = (dr.maximum(self._losses.lost(w, place), 0) for w in (si.wi, wo))
        lobe = one * other * (index2(wo, self._index) / self._scale(self._losses, place)[0])
        if self._coated:
            tint *= dr.sqrt(inputs.color("coat_color", si, active))
        if ctx.mode != mi.TransportMode.Importance:
            across = dr.select(si.wi.z > 0, self._index, 1 / self._index)
            lobe = lobe / dr.select(through, across * across, 1)
        return f + tint * lobe


def slab_of(inputs: Inputs, coated: bool) -> dict[str, Any]:
    """A slab as a dictionary of a plugin, without its type: a pane, or coats on it or on a body."""
    index, rough = index_of(inputs), width_properties(inputs, "specular")
    pane = {"int_ior": index, **rough, **absorption(inputs, "transmission_color", 2)}
    if not coated:
        return pane | {"ext_ior": 1.0}
    coat, glass = coat_properties(inputs), {"type": "roughdielectric", "distribution": "ggx"}
    if not inputs.thin:
        return coat | {"base": glass | rough | {"int_ior": round(index * AIR, DECIMALS)}}
    # The coat below lies between the pane's lower surface and its own.
    outer = width_properties(inputs, "coat")
    below = {name: x for name, x in coat.items() if name not in ("ext_ior", *outer)} | rough
    # Mitsuba refuses equal indices.
    far = glass | outer | {"int_ior": AIR * (1 + 1e-5)}
    inner = {"type": "layered", "inner": True, "origin": inputs.where}
    pane |= inner | {"base": below | inner | {"base": far}}
    return coat | {"base": pane}
