"""Panes, and coats on what transmits light, as slabs of `layered` and `neural_layered`."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import AIR
from urushi.core.appearance import optical_depth
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.plugins.coats import raised, relative, with_far_side
from urushi.mitsuba.reading.below import DECIMALS
from urushi.mitsuba.reading.parameters import opaque
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.bsdfs import SurfaceProposal
from urushi.openpbr_surface.inputs import Inputs, derived, width_properties
from urushi.openpbr_surface.loss_table import AXES, LossAxes, along, sampled_losses, table_of
from urushi.openpbr_surface.shares import index2, index_of, tint_of
from urushi.walk import interface

#: Samples from which the light that a slab loses is measured, for each cosine.
SAMPLES = 1 << 16


class Finish:
    """What a part lacks: the tint of a coated body, and light that meets more than one facet.

    The lobe that returns the light is as that of `Glass`. Its losses on each side are measured from
    samples of white slabs, and are a table.
    """

    DRJIT_STRUCT: ClassVar = dict.fromkeys(
        ("_losses", "_index", "_means"), object
    )  # for frozen functions

    def __init__(self, inputs: Inputs, coated: bool, white: Callable[..., Any] | None):
        """white: makes the white slab, with some parameters replaced; None: it loses no light."""
        self._inputs, self._coated = inputs, coated
        self._losses: Any = None
        index = 1.0 if inputs.thin else index_of(inputs)
        self._index = opaque(index)
        if white is None:
            return
        layers = ("specular", "coat") if coated else ("specular",)
        names = [name for name in AXES if name.split("_")[0] in layers]
        self._axes = LossAxes(inputs, names, layers)
        with dr.suspend_grad():
            bsdf = white({name: mi.load_dict(x) for name, x in self._axes.textures.items()})
            measure = partial(sampled_losses, bsdf, samples=SAMPLES)
            sides = [
                np.maximum(self._axes.measured(partial(measure, below=below, edge=edge)), 0)
                for below, edge in ((False, False), (True, not inputs.thin))
            ]
        self._losses = table_of(sides)
        means = [self._axes.means(side) for side in sides]
        below = np.pi * index**2 * means[1]
        scale = np.maximum(np.pi * means[0] + below, 1e-5)
        # The scale of the lobe, and the share of the light that is returned below.
        self._means: Any = table_of([scale, below / scale]) if self._axes.varying else None
        if self._means is None:
            self._means = [opaque(float(scale)), opaque(float(below / scale))]

    def _at(self, si, active) -> tuple[Any, list, list]:
        """Coordinates at a surface interaction, and the means there."""
        at = self._axes.at(si, active)
        means = self._means(at) if self._axes.varying else self._means
        return self._axes.widths(si, active), at, means

    def _lost(self, w, widths, at):
        """Share of the light from a direction that is lost."""
        return dr.select(w.z > 0, *self._losses([*along(w, widths), *at]))

    def _returned(self, si, active):
        """Directions of the returned light, and their share of all."""
        widths, at, (_, below) = self._at(si, active)
        through = dr.select(si.wi.z > 0, below, 1 - below)
        share = dr.clip(self._lost(si.wi, widths, at), 0, 0.9)
        return with_far_side(Mixture([0.0, 1.0], [1.0]), through), share

    def proposal(self, slab, si, active):
        """The proposal of the slab with it."""
        if self._losses is None:
            return slab
        lobe, share = self._returned(si, active)
        return SurfaceProposal([(slab, 1 - share), (lobe, share)], 0.0)

    def density(self, density, si, wo, active):
        """The density of `proposal` at wo, from the slab's [1/sr]."""
        if self._losses is None:
            return density
        lobe, share = self._returned(si, active)
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
        widths, at, (scale, _) = self._at(si, active)
        lobe = self._lost(si.wi, widths, at) * self._lost(wo, widths, at)
        lobe *= index2(wo, self._index) / scale
        if self._coated:
            tint *= dr.sqrt(inputs.color("coat_color", si, active))
        if ctx.mode != mi.TransportMode.Importance:
            across = dr.select(si.wi.z > 0, self._index, 1 / self._index)
            lobe = lobe / dr.select(through, across * across, 1)
        return f + tint * lobe


def slab_of(inputs: Inputs, coat: dict[str, Any] | None) -> dict[str, Any]:
    """A slab as a dictionary of a plugin, without its type: a pane, or coats on it or on a body.

    coat: the properties of the coat; None: there is none.
    """
    index, rough = index_of(inputs), width_properties(inputs, "specular")
    glass = {"type": "roughdielectric", "distribution": "ggx"}
    if not inputs.thin:
        assert coat is not None  # for the type checker
        return coat | {"base": glass | rough | {"int_ior": round(index * AIR, DECIMALS)}}
    pane: dict[str, Any] = {"int_ior": index, **rough}
    if not inputs.is_constant("transmission_color", 1):
        pane["sigma_t"] = derived(
            inputs, ("transmission_color",), lambda c: 2 * optical_depth(c, DRJIT), color=True
        )
    if coat is None:
        return pane | {"ext_ior": 1.0}
    # The coat below lies between the pane's lower surface and its own.
    outer = width_properties(inputs, "coat")
    below = {name: x for name, x in coat.items() if name not in ("ext_ior", *outer)} | rough
    # Mitsuba refuses equal indices.
    far = glass | outer | {"int_ior": AIR * (1 + 1e-5)}
    inner = {"type": "layered", "inner": True, "origin": inputs.where}
    pane |= inner | {"base": below | inner | {"base": far}}
    return coat | {"base": pane}
