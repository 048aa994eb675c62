"""OpenPBR's bases that transmit light: bodies of glass, and thin walls.

A `Body` mixes two-sided BSDFs by the shares of the base: opaque, an interface with a
medium below it (`Glass`), a thin wall that scatters light (`Sheet`), and slabs of the plugins
`layered` and `neural_layered` (`Slab`): coats on glass, panes, and panes with coats on both sides.
What has the index of what lies outside lets light pass straight on (`Unseen`).
Departures from the specification: a share that is opaque looks the same from inside; both sides of
a thin wall have the coat; specular_weight changes the index of the body, whatever lies above it.
"""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.checks import AIR
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba.frames import SlabMixture, raised, relative
from urushi.mitsuba.reading.grid import varies
from urushi.mitsuba.reading.nested import DECIMALS
from urushi.mitsuba.snapshot import has_gradients
from urushi.mitsuba.surface import bsdf_of
from urushi.openpbr_surface import bsdfs, formulas, parts
from urushi.openpbr_surface.compensation import AXES, LostLight
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parts import INDICES, SHARES, OfInputs, index_of
from urushi.openpbr_surface.two_sided import Glass, Sheet, Unseen
from urushi.walk import interface

#: Colours that are white where losses are measured.
COLORS = ("coat_color", "transmission_color", "specular_color")

#: Widths of interfaces, by which tables have derivatives, as by colours.
ROUGHNESSES = ("specular_roughness", "coat_roughness")

#: Parameters on which the light that slabs lose does not depend.
LOSSLESS = {*COLORS, *SHARES, "coat_weight"}

#: The parameters of panes.
OF_PANES = ("specular_roughness", "specular_roughness_anisotropy", "transmission_color", *INDICES)


class Returned(NamedTuple):
    """Light that meets more than one facet, at a vertex."""

    place: Any  # in the table of lost light
    lost: Any  # share of the light from wi
    scale: Any  # of the lobe
    proposal: Any  # of its directions
    share: Any  # of this proposal


class Slab(OfInputs):
    """A pane, or coats on it or on a body: a slab of the coats' plugins, and what it lacks.

    It lacks the tint of a coated body, and light that meets more than one facet. The lobe that
    returns this light is as that of `two_sided.Glass`.
    """

    def __init__(self, inputs: Inputs, coating: parts.Coating, coated: bool):
        self._coated = coated
        self._layers = ("specular", "coat") if coated else ("specular",)
        self.names = (*OF_PANES, *(bsdfs.OF_COAT if coated else ()))
        super().__init__(inputs, coating)

    def _configure(self):
        inputs = self._inputs
        self._transmit(None if inputs.thin else index_of(inputs))
        self._slab = self._made(inputs)
        differentiable = (*COLORS, *ROUGHNESSES) if self._is_table(inputs) else ()
        self.fixed = {*self.names} - {*differentiable}
        self._measure()

    def _made(self, inputs: Inputs) -> "mi.BSDF":
        plugin = {"type": parts.COATS[not self._is_table(inputs)]}
        return parts.load_part(inputs, slab_of(inputs, self._coated) | plugin)

    def _is_table(self, inputs: Inputs) -> bool:
        """Whether it is a table: where it is isotropic, and its indices are constant."""
        isotropic = all(inputs.is_constant(f"{x}_roughness_anisotropy", 0) for x in self._layers)
        index = inputs.textures["coat_ior"]
        one_index = not (self._coated and (index.is_spatially_varying() or varies(index)))
        return self._coating.tables and isotropic and one_index

    def _measure(self):
        """Measure the light that it loses, unless it stays lost."""
        self._losses: Any = None
        if self._coating.compensated:
            names = [name for name in AXES if name.split("_")[0] in self._layers]
            self._losses = LostLight(self._inputs, names, self._layers, self._white)

    def _white(self, textures: dict[str, Any]) -> "mi.BSDF":
        if not textures and all(self._inputs.is_constant(name, 1) for name in COLORS):
            return self._slab
        return self._made(self._inputs.replaced(dict.fromkeys(COLORS, 1.0) | textures))

    def _vertex(self, si, active):
        slab = self._slab._vertex(si, active)
        if self._losses is None:
            return slab, None
        place = self._losses.at(si, active)
        _, above, _, below = self._losses.means(place)
        below = dr.pi * self._index * self._index * below
        scale = dr.maximum(dr.pi * above + below, 1e-5)
        below = below / scale
        through = dr.select(si.wi.z > 0, below, 1 - below)
        lost = self._losses.lost(si.wi, place)
        sides = SlabMixture(bsdfs.SPREAD, bsdfs.SPREAD, 1 - through, 1.0)
        return slab, Returned(place, lost, scale, sides, dr.clip(lost, 0, 0.9))

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        slab, returned = vertex
        f, pdf = self._slab._f_and_pdf(slab, ctx, si, wo, active)
        at, through = self._inputs.at(si, active), si.wi.z * wo.z < 0
        tint = parts.tint_of(self._inputs, at)
        if self._coated and not self._inputs.thin:
            # Light from below that the surface of the body does not reflect crosses it twice.
            coat = formulas.interface_index(at.coat_ior, DRJIT)
            a, b = raised(si.wi), relative(si.wi, wo)
            first = interface.reflection(a, b, at.widths("specular"), coat / self._index)
            below = (si.wi.z < 0) & ~through
            f = dr.select(below, first + tint * tint * (f - first), f * dr.select(through, tint, 1))
        if returned is None:
            return f, pdf
        one, other = returned.lost, self._losses.lost(wo, returned.place)
        lobe = dr.maximum(one, 0) * dr.maximum(other, 0)
        lobe *= parts.index2(wo, self._index) / returned.scale
        if self._coated:
            tint *= dr.sqrt(at.coat_color)
        if ctx.mode != mi.TransportMode.Importance:
            lobe = lobe / dr.select(through, dr.square(self._index_across(si.wi)), 1)
        pdf = dr.lerp(pdf, returned.proposal.pdf(si.wi, wo), returned.share)
        return f + tint * lobe, pdf

    def _proposal(self, vertex, si, active):
        slab, returned = vertex
        proposal = self._slab._proposal(slab, si, active)
        if returned is None:
            return proposal
        return bsdfs.SurfaceProposal(
            [(proposal, 1 - returned.share), (returned.proposal, returned.share)]
        )

    def _update(self, keys):
        self._slab.parameters_changed(list(keys))
        if not keys or not {*keys} <= LOSSLESS:
            self._measure()


def slab_of(inputs: Inputs, coated: bool) -> dict[str, Any]:
    """A slab as a dictionary of a plugin, without its type: a pane, or coats on it or on a body."""
    index, rough = index_of(inputs), parts.width_properties(inputs, "specular")
    pane = {"int_ior": index, **rough, **parts.absorption(inputs, "transmission_color", 2)}
    if not coated:
        return pane | {"ext_ior": 1.0}
    coat, glass = parts.coat_properties(inputs), {"type": "roughdielectric", "distribution": "ggx"}
    if not inputs.thin:
        return coat | {"base": glass | rough | {"int_ior": round(index * AIR, DECIMALS)}}
    # The coat below lies between the pane's lower surface and its own.
    outer = parts.width_properties(inputs, "coat")
    below = {name: x for name, x in coat.items() if name not in ("ext_ior", *outer)} | rough
    # Mitsuba refuses equal indices.
    far = glass | outer | {"int_ior": AIR * (1 + 1e-5)}
    inner = {"type": "layered", "inner": True, "origin": inputs.where}
    pane |= inner | {"base": below | inner | {"base": far}}
    return coat | {"base": pane}


class Body(bsdfs.Blend):
    """A surface that transmits light: a mixture of two-sided BSDFs."""

    def _configure(self):
        """Make the layers that parameters need."""
        self._ior: float | None = None  # until all are made
        inputs, index = self._inputs, index_of(self._inputs)
        layers, unseen = [], []
        rest = parts.opaque_share(inputs)
        if rest is not None:
            layers.append(bsdfs.Layer(bsdf_of(bsdfs.OpenPBRSurface(rest, self._coating)), "opaque"))
        clear, scatters = map(inputs.transmits, SHARES[1:])
        if inputs.thin and scatters:
            layers.append(bsdfs.Layer(bsdf_of(Sheet(inputs)), "scattering"))
        if clear or (scatters and not inputs.thin):
            share = "clear" if inputs.thin else "transmitting"
            for coated, absent in ((False, 1), (True, 0)):
                if inputs.is_constant("coat_weight", absent):
                    continue
                if Unseen.is_right(inputs, coated):
                    unseen.append(bsdfs.Layer(Unseen(inputs, coated), share, coated))
                    continue
                slab = coated or inputs.thin
                surface = Slab(inputs, self._coating, coated) if slab else Glass(inputs)
                layers.append(bsdfs.Layer(bsdf_of(surface), share, coated))
        self._layers, self._unseen, self._ior = layers, unseen, index
        self._transmit(None if inputs.thin else index)

    def _flags(self):
        flags = mi.BSDFFlags
        straight = [flags.Null | flags.FrontSide | flags.BackSide] if self._unseen else []
        return [*super()._flags(), *straight]

    def _straight(self, ctx, si, active):
        """Probability that light goes straight on, and the mean transmittance there."""
        share, total = mi.Float(0), mi.Spectrum(0)
        for layer, own in zip(self._unseen, self._weights(self._unseen, si, active), strict=True):
            share += own
            total += own * layer.bsdf.passed(si, active)
        seen = mi.Bool(active) & (si.wi.z != 0) & ctx.is_enabled(mi.BSDFFlags.Null, 2)
        return share, dr.select(seen, total, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs, weight = super().sample(ctx, si, sample1, sample2, active)
        if not self._unseen:
            return bs, weight
        share, total = self._straight(ctx, si, active)
        straight = sample1 >= 1 - share  # the other parts have the shares below it
        passes = straight & dr.any(total > 0)
        bs.wo = dr.select(straight, -si.wi, bs.wo)
        bs.pdf = dr.select(straight, dr.select(passes, share, 0), bs.pdf)
        bs.eta = dr.select(straight, 1, bs.eta)
        bs.sampled_type = dr.select(straight, mi.UInt32(+mi.BSDFFlags.Null), bs.sampled_type)
        bs.sampled_component = dr.select(straight, mi.UInt32(2), bs.sampled_component)
        weight = dr.select(straight, 0, weight)
        return bs, dr.select(passes, total / dr.maximum(share, 1e-6), weight)

    def eval_null_transmission(self, si, active=True):
        return self._straight(mi.BSDFContext(), si, active)[1]

    def traverse(self, callback):
        names = [*SHARES]
        for layer in (*self._layers, *self._unseen):
            names += layer.bsdf.names
        if "transmission_color" in names:  # a coat may appear
            names += ("coat_weight", *bsdfs.OF_COAT)
        self._inputs.traverse(callback, dict.fromkeys(names), self._fixed())

    def _fixed(self) -> set[str]:
        """The parameters by which a part has no derivatives."""
        return {name for layer in self._layers for name in layer.bsdf.fixed}

    def _update(self, keys):
        changed = {*keys}
        for name in sorted(self._fixed()):
            if has_gradients(self._inputs.textures[name]):
                raise ParameterError(
                    f"{self._inputs.where}: {name} carries gradients, but panes and coats on what "
                    "transmits light have derivatives by colours and roughness alone, and by walks "
                    "none; disable them"
                )
        if self._inputs.refresh() or index_of(self._inputs) != self._ior:
            self._configure()
        else:
            for layer in self._layers:
                if not changed or not changed.isdisjoint(layer.bsdf.names):
                    layer.bsdf.parameters_changed(list(keys))
