"""OpenPBR's bases that transmit light: bodies of glass, and thin walls.

A `Body` mixes two-sided BSDFs by the shares of the base: opaque, an interface with a
medium below it (`Glass`), a thin wall that scatters light (`Sheet`), and slabs of the plugins
`layered` and `neural_layered` (`slabs`): coats on glass, panes, and panes with coats on both sides.
What has the index of what lies outside lets light pass straight on (`Unseen`).
Departures from the specification: a share that is opaque looks the same from inside; both sides of
a thin wall have the coat; specular_weight changes the index of the body, whatever lies above it.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba.plugins.frames import Turn, TurnedMixture, above_surface, raised, with_far_side
from urushi.mitsuba.surface import Surface, bsdf_of
from urushi.openpbr_surface.bsdfs import OF_COAT, Part, SurfaceProposal
from urushi.openpbr_surface.inputs import Inputs, load_part
from urushi.openpbr_surface.shares import INDICES, SHARES, index_of, opaque_share, shares
from urushi.openpbr_surface.slabs import Finish, slab_of
from urushi.openpbr_surface.two_sided import Glass, Sheet, Unseen

#: Colours that are white where losses are measured.
COLORS = ("coat_color", "transmission_color", "specular_color")

#: Parameters that the tables of slabs hold as constants.
TABULATED = ("specular_roughness", "transmission_color", "coat_roughness", "coat_ior", "coat_color")

#: The parameters of panes.
OF_PANES = ("specular_roughness", "specular_roughness_anisotropy", "transmission_color", *INDICES)

#: Parameters on which the light that slabs lose does not depend.
LOSSLESS = (*COLORS, *SHARES, "coat_weight")


class Body(Surface):
    """A surface that transmits light: a mixture of two-sided BSDFs."""

    def __init__(self, inputs: Inputs, make: Callable[[list], list]):
        """make: returns the parts: BSDF, weight at an interaction, and `Finish` or None. It
        takes former ones, whose BSDFs are reused, or an empty list."""
        self._inputs, self._make = inputs, make
        self._parts: list = []
        self._unseen: list = []  # `Unseen` and its weight at an interaction
        self._configure()
        super().__init__(mi.Properties("openpbr"), inputs.where)

    def _configure(self):
        self._ior = index_of(self._inputs)
        self._transmit(None if self._inputs.thin else self._ior)
        self._take(self._make([]))

    def _take(self, made: list) -> None:
        self._parts = [part for part in made if not isinstance(part[0], Unseen)]
        self._unseen = [part[:2] for part in made if isinstance(part[0], Unseen)]

    def _flags(self):
        flags = mi.BSDFFlags
        straight = [flags.Null | flags.FrontSide | flags.BackSide] if self._unseen else []
        return [*super()._flags(), *straight]

    def _straight(self, ctx, si, active):
        """Probability that light goes straight on, and the mean transmittance there."""
        share, total = mi.Float(0), mi.Spectrum(0)
        for unseen, weight in self._unseen:
            own = weight(si, active)
            share += own
            total += own * unseen.passed(si, active)
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
        return bs, dr.select(
            passes, total / dr.maximum(share, 1e-6), dr.select(straight, 0, weight)
        )

    def eval_null_transmission(self, si, active=True):
        return self._straight(mi.BSDFContext(), si, active)[1]

    def _vertex(self, si, active):
        turn = None
        if "geometry_tangent" in self._inputs.maps:
            turn = Turn(*self._inputs.tangent(si, active))
        parts = []
        for bsdf, weight, _ in self._parts:
            own = self._interaction(turn, bsdf, si)
            parts.append(Part(bsdf, bsdf._vertex(own, active), weight(si, active)))
        return turn, parts

    def _interaction(self, turn, bsdf, si):
        if not bsdf._transmits:  # it looks the same from both sides, and turns its tangent
            return above_surface(si)
        return si if turn is None else turn.interaction(si)

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        turn, parts = vertex
        f, pdf, near = mi.Spectrum(0), mi.Float(0), si.wi.z * wo.z > 0
        for part, (bsdf, _, finish) in zip(parts, self._parts, strict=True):
            own = self._interaction(turn, bsdf, si)
            if bsdf._transmits:
                towards = wo if turn is None else turn.inside(wo)
                value, density = bsdf._f_and_pdf(part.vertex, ctx, own, towards, active)
            else:
                found = bsdf._f_and_pdf(part.vertex, ctx, own, raised(wo), active & near)
                value, density = (dr.select(near, x, 0) for x in found)
            if finish is not None:
                value = finish.f(value, ctx, own, towards, active)
                density = finish.density(density, own, towards, active)
            f += part.weight * value
            pdf += part.weight * density
        return f, pdf

    def _proposal(self, vertex, si, active):
        turn, parts = vertex
        proposals = []
        for part, (_, _, finish) in zip(parts, self._parts, strict=True):
            own = self._interaction(turn, part.bsdf, si)
            proposal = part.bsdf._proposal(part.vertex, own, active)
            if not part.bsdf._transmits:
                proposal = with_far_side(proposal, 0.0)
            else:
                proposal = finish.proposal(proposal, own, active) if finish else proposal
                proposal = proposal if turn is None else TurnedMixture(proposal, turn)
            proposals.append((proposal, part.weight))
        return SurfaceProposal(proposals, 0.0)

    def traverse(self, callback):
        names = [*SHARES]
        for part in (*self._parts, *self._unseen):
            names += part[0].names
        if "transmission_color" in names:  # a coat may appear
            names += ("coat_weight", *OF_COAT)
        self._inputs.traverse(callback, dict.fromkeys(names), self._fixed())

    def _fixed(self) -> set[str]:
        """The parameters by which a part has no derivatives."""
        return {name for part in self._parts for name in getattr(part[0], "fixed", ())}

    def _update(self, keys):
        changed = {*keys}
        for name in sorted(filter(self._inputs.has_gradients, self._fixed())):
            raise ParameterError(
                f"{self._inputs.where}: {name} carries gradients, but panes and coats on what "
                "transmits light have derivatives by transmission_color and coat_color alone, "
                "and by walks or of spectra none; disable them"
            )
        if self._inputs.refresh() or index_of(self._inputs) != self._ior:
            self._configure()
        else:
            for bsdf, _, _ in self._parts:
                if not changed or not changed.isdisjoint(bsdf.names):
                    bsdf.parameters_changed(list(keys))
            if not changed or not changed <= {*LOSSLESS}:
                self._take(self._make(self._parts))

    def to_string(self):
        parts = ",\n".join(str(bsdf) for bsdf, _, _ in self._parts)
        return "OpenPBR[\n  " + parts.replace("\n", "\n  ") + "\n]"


def transmitting(
    inputs: Inputs,
    opaque: Callable[[Inputs], "mi.BSDF"],
    coat: Callable[[Inputs], dict[str, Any]],
    tables: bool,
    compensated: bool,
) -> "mi.BSDF":
    """A surface that transmits light.

    opaque: makes the opaque surface. coat: the properties of a coat without what lies below.
    tables: whether constant slabs are tables. compensated: whether slabs lose no energy.
    """

    def weight(of: str, coated: bool | None) -> Callable[..., Any]:
        def at(si, active):
            share = getattr(shares(*(inputs.number(x, si, active) for x in SHARES)), of)
            if coated is None:
                return share
            cover = inputs.number("coat_weight", si, active)
            return share * (cover if coated else 1 - cover)

        return at

    def slab(inputs: Inputs, coated: bool) -> "mi.BSDF":
        described = slab_of(inputs, coat(inputs) if coated else None)
        layers = ("specular", "coat") if coated else ("specular",)
        one = all(inputs.is_constant(f"{x}_roughness_anisotropy", 0) for x in layers)
        given = [inputs.textures[x] for x in (TABULATED if coated else TABULATED[:2])]
        numbers = not any(x.is_spatially_varying() for x in given)  # nor bitmaps of one value
        plugin = "neural_layered" if tables and one and numbers else "layered"
        made = load_part(inputs, described | {"type": plugin})
        made.names = (*OF_PANES, *(OF_COAT if coated else ()))
        differentiable = COLORS if plugin == "neural_layered" and not mi.is_spectral else ()
        made.fixed = {*made.names} - {*differentiable}
        return made

    def whitened(bsdf: Any, make: Callable[[Inputs], Any], textures: dict[str, Any]) -> Any:
        if not textures and all(inputs.is_constant(name, 1) for name in COLORS):
            return bsdf
        values = {name: mi.load_dict(x) for name, x in textures.items()}
        return make(inputs.replaced(dict.fromkeys(COLORS, 1.0) | values))

    def glass(inputs: Inputs) -> "mi.BSDF":
        return bsdf_of(Glass(inputs))

    def sheet(inputs: Inputs) -> "mi.BSDF":
        return bsdf_of(Sheet(inputs))

    def parts(former: list) -> list:
        found: list[tuple[Any, Callable[..., Any], Any]] = []
        unseen: list[tuple[Any, Callable[..., Any], Any]] = []

        def part(make: Callable[[Inputs], Any], given: Inputs) -> Any:
            return former[len(found)][0] if former else make(given)

        rest = opaque_share(inputs)
        if rest is not None:
            found.append((part(opaque, rest), weight("opaque", None), None))
        scatters = [name for name in SHARES[1:] if inputs.transmits(name)]
        if inputs.thin and SHARES[2] in scatters:
            found.append((part(sheet, inputs), weight("scattering", None), None))
        names = [name for name in scatters if not inputs.thin or name == SHARES[1]]
        if not names:
            return found
        of = "clear" if inputs.thin else "transmitting"
        for coated, absent in ((False, 1), (True, 0)):
            if inputs.is_constant("coat_weight", absent):
                continue
            if Unseen.is_right(inputs, coated):
                unseen.append((Unseen(inputs, coated), weight(of, coated), None))
                continue
            make = partial(slab, coated=coated) if coated or inputs.thin else glass
            bsdf, finish = part(make, inputs), None
            if make is not glass:
                white = partial(whitened, bsdf, make) if compensated else None
                finish = Finish(inputs, coated, white)
            found.append((bsdf, weight(of, coated), finish))
        return [*found, *unseen]

    return bsdf_of(Body(inputs, parts))
