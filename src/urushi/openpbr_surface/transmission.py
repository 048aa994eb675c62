"""OpenPBR's bases that transmit light: bodies of glass, and thin walls.

A `Body` mixes two-sided BSDFs by the shares of the base: opaque (`Mirrored`), an interface with a
medium below it (`Glass`), a thin wall that scatters light (`Sheet`), and slabs of the plugins
`layered` and `neural_layered`: coats on glass, panes, and panes with coats on both sides.
Departures from the specification: a share that is opaque looks the same from inside; both sides of
a thin wall have the coat; specular_weight changes the index of the body, whatever lies above it.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import AIR, MIN_INDEX_STEP, Widths
from urushi.core import fresnel, microfacet
from urushi.core.appearance import optical_depth
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba.interface_albedo import InterfaceAlbedo, Interpolated
from urushi.mitsuba.plugins.coats import Turn, TurnedMixture, raised
from urushi.openpbr_surface import formulas, model
from urushi.openpbr_surface.bsdfs import MIN_SHARE, Part, SurfaceProposal
from urushi.openpbr_surface.compensation import hemisphere_weights, sampled_losses
from urushi.openpbr_surface.film import FilmFresnel
from urushi.openpbr_surface.inputs import Inputs, derived, width_properties
from urushi.walk import interface

#: Least share of the proposal for light that meets more than one facet.
LEAST_LOST = 0.01

#: Samples from which the light that a slab loses is measured, for each cosine.
SAMPLES = 1 << 16

#: The parameters on which the shares depend.
SHARES = ("base_metalness", "transmission_weight", "subsurface_weight")

#: The parameters on which the index of a body depends.
INDICES = ("specular_ior", "specular_weight")


#: Colours that are white where losses are measured.
COLORS = ("coat_color", "transmission_color", "specular_color")


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


def index_of(inputs: Inputs) -> float:
    """The index of the base relative to air.

    Raises:
        ParameterError: it varies.
    """
    for name in INDICES:
        if not inputs.is_uniform([name]):
            raise ParameterError(
                f"{inputs.where}: {name} is a texture, but what transmits light needs one index; "
                "give a number"
            )
    ior, weight = (inputs.middle(name) for name in INDICES)
    ior = float(formulas.modulated_index(max(ior, formulas.LEAST_INDEX), weight))
    return min(max(ior, 1 / 3), 3.0)


class TwoSided(NamedTuple):
    """A proposal for both sides: directions of one, and a cosine lobe on the side opposite to wi.

    Attributes:
        proposal: for directions above the horizon. through: the probability of the other side.
    """

    proposal: Any
    through: Any

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        near = (1 - self.through) * self.proposal.pdf(raised(wi), raised(wo))
        return dr.select(wi.z * wo.z > 0, near, self.through * dr.inv_pi * dr.abs(wo.z))

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        crosses = choice < self.through
        own = dr.clip((choice - self.through) / dr.maximum(1 - self.through, 1e-6), 0, 0.99999994)
        near = self.proposal.sample(raised(wi), own, u)
        wo = dr.select(crosses, mi.warp.square_to_cosine_hemisphere(u), near)
        return mi.Vector3f(wo.x, wo.y, dr.select((wi.z > 0) != crosses, wo.z, -wo.z))


class GlassProposal(NamedTuple):
    """Facets seen from wi, which reflect or refract by Fresnel's terms, and cosine lobes.

    Attributes:
        widths: of the facets. eta: index on the far side relative to wi's.
        lost: share of the cosine lobes of both sides.
    """

    widths: Any
    eta: Any
    lost: Any

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        _, density = interface.scatter(raised(wi), _relative(wi, wo), self.widths, self.eta)
        return (1 - self.lost) * density + self.lost * 0.5 * dr.inv_pi * dr.abs(wo.z)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`. It is at the horizon where facets send light nowhere."""
        diffuse = choice < self.lost
        own = dr.clip((choice - self.lost) / (1 - self.lost), 0, 0.99999994)
        wo, weight, _ = interface.sample(raised(wi), self.widths, self.eta, own, u.x, u.y)
        wo = dr.select(weight > 0, wo, mi.Vector3f(1, 0, 0))
        cosine = mi.warp.square_to_cosine_hemisphere(u)
        cosine.z = dr.select(choice < 0.5 * self.lost, cosine.z, -cosine.z)
        return _relative(wi, dr.select(diffuse, cosine, wo))


def _relative(wi, wo):
    """wo with z > 0 on the side of wi, and the inverse."""
    return mi.Vector3f(wo.x, wo.y, dr.select(wi.z > 0, wo.z, -wo.z))


def _above(si):
    """The interaction seen from the same direction above the surface."""
    seen = mi.SurfaceInteraction3f(si)
    seen.wi = raised(si.wi)
    return seen


class GlassVertex(NamedTuple):
    """`Glass` at a surface interaction.

    Attributes:
        widths: as of `model.BaseVertex`. eta: index on the far side relative to wi's.
        tint: of transmitted light. specular: specular_color.
        lost: share of the light from wi that meets a second facet.
        scale: of the product of lost shares, a lobe [1/sr].
    """

    widths: Any
    eta: Any
    tint: Any
    specular: Any
    lost: Any
    scale: Any


class Lost:
    """Light that a slab loses on each side, measured from its samples: a lobe that returns it.

    The lobe is as that of `Glass`, in coordinates of a table.
    """

    def __init__(self, slab: "mi.BSDF", index: float):
        """slab: the white one. index: below it relative to that above."""
        uv = np.full((1, 2), 0.5)
        with dr.suspend_grad():
            sides = [sampled_losses(slab, uv, SAMPLES, below)[0] for below in (False, True)]
        losses = np.maximum(np.stack(sides, axis=-1), 0).astype(np.float32)
        self._losses = Interpolated(losses)
        means = hemisphere_weights() @ losses
        self._index, self._scale = index, np.pi * (means[0] + index**2 * means[1])

    def lobe(self, wi, wo):
        """The lobe of importance [1/sr]."""
        lost = [dr.select(w.z > 0, *self._losses([dr.sqrt(dr.abs(w.z))])) for w in (wi, wo)]
        return lost[0] * lost[1] * (_index2(wo, self._index) / max(self._scale, 1e-5))


def _index2(w, index):
    """The square of the index on the side of a direction."""
    return dr.select(w.z > 0, 1, index * index)


def define(proposal_bsdf: type) -> Callable[..., "mi.BSDF"]:
    """Make the function that makes the surface; see `define_proposal_bsdf`."""

    class Glass(proposal_bsdf):
        """The surface of a body whose medium transmits light (3.2.4)."""

        def __init__(self, inputs: Inputs):
            super().__init__(mi.Properties("openpbr_glass"))
            self._inputs = inputs
            self._configure()
            self._kept.keep(self)

        def _configure(self):
            index = index_of(self._inputs)
            if abs(index - 1) < MIN_INDEX_STEP:
                raise ParameterError(
                    f"{self._inputs.where}: no interface bends light into the body, whose index is "
                    "1; give another specular_ior, or Mitsuba's BSDF 'null'"
                )
            self._transmit(index)
            # Tables have one width.
            self.returns_lost = self._inputs.is_constant("specular_roughness_anisotropy", 0)
            self._albedos = InterfaceAlbedo(index), InterfaceAlbedo(1 / index)
            film = not self._inputs.is_constant("thin_film_weight", 0)
            self._film: Any = FilmFresnel(self._inputs) if film else None

        def _vertex(self, si, active):
            inputs, scale = self._inputs, 0.0
            widths, lost = _widths(inputs, si, active), mi.Float(0)
            if self.returns_lost:
                means = self._sides(lambda table, eta: 1 - sum(table.both_mean(widths, eta)))
                scale = 1 / dr.maximum(dr.pi * (means[0] + self._index**2 * means[1]), 1e-5)
                lost = self._lost(widths, si.wi)
            tint, specular = tint_of(inputs, si, active), inputs.color("specular_color", si, active)
            return GlassVertex(widths, self._index_across(si.wi), tint, specular, lost, scale)

        def _sides(self, function):
            """A function of the tables of light from above and from below."""
            etas = self._index, 1 / self._index
            return list(map(function, self._albedos, etas))

        def _lost(self, widths, w):
            """Share of the light from a direction that meets a second facet."""
            if not self.returns_lost:
                return mi.Float(0)
            passed = self._sides(lambda table, eta: sum(table.both(dr.abs(w.z), widths, eta)))
            return dr.clip(1 - dr.select(w.z > 0, *passed), 0, 1)

        def _f(self, vertex, ctx, si, wo, active):
            above, through = si.wi.z > 0, si.wi.z * wo.z < 0
            a, b = raised(si.wi), _relative(si.wi, wo)
            lobe, cosine = microfacet.reflection_lobe(a, b, vertex.widths)
            bare = fresnel.dielectric(dr.abs(cosine), vertex.eta)[0]
            reflected = mi.Spectrum(bare)
            passed = mi.Spectrum(interface.transmission(a, b, vertex.widths, vertex.eta)[0])
            if self._film:
                reflected = self._filmed(dr.abs(cosine), vertex.eta, above, si, active)
                facet = dr.abs(dr.dot(a, dr.normalize(a + vertex.eta * b)))
                unfilmed = 1 - fresnel.dielectric(facet, vertex.eta)[0]
                filmed = 1 - self._filmed(facet, vertex.eta, above, si, active)
                passed *= filmed / dr.maximum(unfilmed, 1e-6)
            reflected *= lobe * dr.select(above, vertex.specular, 1)
            # Light that would meet a second facet leaves on both sides (Kulla and Conty 2017).
            lost = vertex.lost * self._lost(vertex.widths, wo) * vertex.scale
            f = dr.select(through, passed, reflected) + lost * _index2(wo, self._index)
            f *= dr.select(through, vertex.tint, 1)
            if ctx.mode == mi.TransportMode.Importance:
                return f
            return f / dr.select(through, dr.square(vertex.eta), 1)

        def _filmed(self, cosine, eta, above, si, active):
            """The Fresnel term under the film, which is the same on both sides of a facet."""
            outside = fresnel.dielectric(cosine, eta)[1]
            outside = dr.select(above, cosine, dr.maximum(outside, 0))
            film = self._film.dielectric(outside, mi.Float(self._index), si, active)
            return dr.select(above | (outside > 0), film, 1)

        def _proposal(self, vertex, si, active):
            return GlassProposal(vertex.widths, vertex.eta, dr.clip(vertex.lost, LEAST_LOST, 0.9))

        def traverse(self, callback):
            names = "specular_color", "specular_roughness", "specular_roughness_anisotropy"
            for name in (*names, *INDICES, "transmission_color"):
                callback.put(name, self._inputs.textures[name], mi.ParamFlags.Differentiable)
            if self._film:
                self._film.traverse(callback)

        def _update(self, keys):
            self._configure()

        def to_string(self):
            return "OpenPBRGlass[]"

    class Sheet(proposal_bsdf):
        """A thin wall of a medium that scatters light to both sides, below interfaces (3.2.3)."""

        def __init__(self, inputs: Inputs):
            super().__init__(mi.Properties("openpbr_sheet"))
            self._inputs, self._base = inputs, model.Base(inputs, False, False)
            self._transmit()

        def _vertex(self, si, active):
            inputs, vertex = self._inputs, self._base.vertex(si, active)
            color = inputs.color("subsurface_color", si, active)
            forward = 0.5 + 0.5 * inputs.number("subsurface_scatter_anisotropy", si, active)
            near, far = color * (1 - forward), color * forward
            return vertex._replace(color=near), vertex._replace(color=far), forward

        def _f(self, vertex, ctx, si, wo, active):
            near, far, _ = vertex
            through, wo, si = si.wi.z * wo.z < 0, raised(wo), _above(si)
            passed = self._base.diffuse(far, si, wo, active)
            lobe, cosine = microfacet.reflection_lobe(si.wi, wo, near.widths)
            reflected = self._base.glossy_diffuse(near, lobe, dr.abs(cosine), si, wo, active)
            return dr.select(through, passed, reflected)

        def _proposal(self, vertex, si, active):
            near, _, forward = vertex
            reflected = self._base.reflected(raised(si.wi), near)
            through = dr.clip((1 - reflected) * forward, 0, 1 - MIN_SHARE)
            share = dr.clip(reflected / (1 - through), MIN_SHARE, 1 - MIN_SHARE)
            return TwoSided(Mixture([share, 1 - share], [near.widths]), through)

        def traverse(self, callback):
            names = "subsurface_color", "subsurface_scatter_anisotropy", "base_diffuse_roughness"
            for name in (*names, "specular_roughness", "specular_ior", "specular_color"):
                callback.put(name, self._inputs.textures[name], mi.ParamFlags.Differentiable)

        def to_string(self):
            return "OpenPBRSheet[]"

    class Mirrored(proposal_bsdf):
        """An opaque surface that looks the same from both sides."""

        def __init__(self, surface: "mi.BSDF"):
            super().__init__(mi.Properties("openpbr_mirrored"))
            self.surface = surface
            self._transmit()

        def _vertex(self, si, active):
            return self.surface._vertex(_above(si), active)

        def _f(self, vertex, ctx, si, wo, active):
            return self._f_and_pdf(vertex, ctx, si, wo, active)[0]

        def _f_and_pdf(self, vertex, ctx, si, wo, active):
            near = si.wi.z * wo.z > 0
            found = self.surface._f_and_pdf(vertex, ctx, _above(si), raised(wo), active & near)
            return tuple(dr.select(near, x, 0) for x in found)

        def _proposal(self, vertex, si, active):
            return TwoSided(self.surface._proposal(vertex, _above(si), active), 0.0)

        def traverse(self, callback):
            callback.put("surface", self.surface, mi.ParamFlags.Differentiable)

        def to_string(self):
            return str(self.surface)

    class Body(proposal_bsdf):
        """A surface that transmits light: a mixture of two-sided BSDFs."""

        def __init__(self, inputs: Inputs, make: Callable[[], list]):
            """make: returns the parts: BSDF, weight at an interaction, and what `finish` takes."""
            super().__init__(mi.Properties("openpbr"))
            self._where, self._inputs, self._make = inputs.where, inputs, make
            self._configure()
            self._kept.keep(self)

        def _configure(self):
            self._parts = self._make()
            self._transmit(None if self._inputs.thin else index_of(self._inputs))

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
            # An opaque surface turns its tangent itself.
            return si if turn is None or isinstance(bsdf, Mirrored) else turn.interaction(si)

        def _f(self, vertex, ctx, si, wo, active):
            return self._f_and_pdf(vertex, ctx, si, wo, active)[0]

        def _f_and_pdf(self, vertex, ctx, si, wo, active):
            turn, parts = vertex
            f, pdf = mi.Spectrum(0), mi.Float(0)
            for part, (bsdf, _, finish) in zip(parts, self._parts, strict=True):
                own = self._interaction(turn, bsdf, si)
                towards = wo if own is si else turn.inside(wo)
                value, density = bsdf._f_and_pdf(part.vertex, ctx, own, towards, active)
                if finish is not None:
                    value = finish(value, ctx, own, towards, active)
                f += part.weight * value
                pdf += part.weight * density
            return f, pdf

        def _proposal(self, vertex, si, active):
            turn, parts = vertex
            proposals = []
            for part in parts:
                own = self._interaction(turn, part.bsdf, si)
                proposal = part.bsdf._proposal(part.vertex, own, active)
                proposals.append(
                    (proposal if own is si else TurnedMixture(proposal, turn), part.weight)
                )
            return SurfaceProposal(proposals, 0.0)

        def traverse(self, callback):
            for name in (*SHARES, "coat_weight"):
                texture = self._inputs.textures[name]
                callback.put(name, texture, mi.ParamFlags.Differentiable)
            for i, (bsdf, _, _) in enumerate(self._parts):
                callback.put(f"part_{i}", bsdf, mi.ParamFlags.Differentiable)

        def _update(self, keys):
            if self._inputs.refresh() or any(finish for _, _, finish in self._parts):
                self._configure()

        def to_string(self):
            parts = ",\n".join(str(bsdf) for bsdf, _, _ in self._parts)
            return "OpenPBR[\n  " + parts.replace("\n", "\n  ") + "\n]"

    def make(
        inputs: Inputs,
        opaque: Callable[[Inputs], "mi.BSDF"],
        coat: Callable[[Inputs], dict[str, Any]],
        tables: bool,
        compensated: bool,
    ) -> "mi.BSDF":
        """A surface that transmits light.

        opaque: makes the opaque surface. coat: the properties of a coat without what lies below.
        tables: whether slabs of one layer are tables. compensated: whether slabs lose no energy.
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
            described = _slab(inputs, coat(inputs) if coated else None)
            uniform = inputs.is_uniform(["specular_roughness", "transmission_color"])
            one = not coated and inputs.is_constant("specular_roughness_anisotropy", 0)
            plugin = "neural_layered" if tables and one and uniform else "layered"
            return mi.load_dict(described | {"type": plugin})

        def parts() -> list:
            found: list[tuple[Any, Callable[..., Any], Any]] = []
            rest = opaque_share(inputs)
            if rest is not None:
                found.append((Mirrored(opaque(rest)), weight("opaque", None), None))
            scatters = [name for name in SHARES[1:] if inputs.transmits(name)]
            if inputs.thin and SHARES[2] in scatters:
                found.append((Sheet(inputs), weight("scattering", None), None))
            names = [name for name in scatters if not inputs.thin or name == SHARES[1]]
            if not names:
                return found
            of = "clear" if inputs.thin else "transmitting"
            for coated, absent in ((False, 1), (True, 0)):
                if inputs.is_constant("coat_weight", absent):
                    continue
                make = partial(slab, coated=coated) if coated or inputs.thin else Glass
                part, finish = make(inputs), None
                if not isinstance(part, Glass) or not part.returns_lost:
                    white = part
                    if not all(inputs.is_constant(name, 1) for name in COLORS):
                        white = make(inputs.replaced(dict.fromkeys(COLORS, 1.0)))
                    index = 1.0 if inputs.thin else index_of(inputs)
                    lost = Lost(white, index) if compensated else None
                    finish = Finish(inputs, coated, lost)
                found.append((part, weight(of, coated), finish))
            return found

        return Body(inputs, parts)

    return make


def _widths(inputs: Inputs, si, active) -> Any:
    """The GGX width of the base, or both."""
    rough = inputs.number("specular_roughness", si, active)
    if inputs.is_constant("specular_roughness_anisotropy", 0):
        return formulas.lobe_width(rough, DRJIT)
    bias = inputs.number("specular_roughness_anisotropy", si, active)
    return Widths(*formulas.lobe_widths(rough, bias, DRJIT))


def tint_of(inputs: Inputs, si, active) -> Any:
    """The factor of light that crosses the base's interface, without a transmission_depth."""
    clear, scattering = inputs.transmits(SHARES[1]), inputs.transmits(SHARES[2])
    color = inputs.color("transmission_color", si, active)
    if not clear or inputs.middle("transmission_depth") > 0:
        return mi.Spectrum(1)
    if not scattering:
        return color
    found = shares(*(inputs.number(name, si, active) for name in SHARES))
    return dr.lerp(color, 1, found.scattering / dr.maximum(found.transmitting, 1e-6))


class Finish:
    """What a part lacks: the tint of a coated body, and light that meets more than one facet."""

    def __init__(self, inputs: Inputs, coated: bool, lost: Lost | None):
        self._inputs, self._coated, self._lost = inputs, coated, lost
        self._index = 1.0 if inputs.thin else index_of(inputs)

    def __call__(self, f, ctx, si, wo, active):
        """f [1/sr] of the slab with it."""
        inputs, through = self._inputs, si.wi.z * wo.z < 0
        tint = tint_of(inputs, si, active)
        if self._coated and not inputs.thin:
            # Light from below that the surface of the body does not reflect crosses it twice.
            coat = formulas.interface_index(inputs.number("coat_ior", si, active), DRJIT)
            a, b = raised(si.wi), _relative(si.wi, wo)
            first = interface.reflection(a, b, _widths(inputs, si, active), coat / self._index)
            below = (si.wi.z < 0) & ~through
            f = dr.select(below, first + tint * tint * (f - first), f * dr.select(through, tint, 1))
        if self._lost is None:
            return f
        lobe = self._lost.lobe(si.wi, wo)
        if self._coated:
            tint *= dr.sqrt(inputs.color("coat_color", si, active))
        if ctx.mode != mi.TransportMode.Importance:
            across = dr.select(si.wi.z > 0, self._index, 1 / self._index)
            lobe = lobe / dr.select(through, across * across, 1)
        return f + tint * lobe


def _slab(inputs: Inputs, coat: dict[str, Any] | None) -> dict[str, Any]:
    """A slab as a dictionary of a plugin, without its type: a pane, or coats on it or on a body.

    coat: the properties of the coat; None: there is none.
    """
    index, rough = index_of(inputs), width_properties(inputs, "specular")
    glass = {"type": "roughdielectric", "distribution": "ggx"}
    if not inputs.thin:
        assert coat is not None  # for the type checker
        return coat | {"base": glass | rough | {"int_ior": index * AIR}}
    pane: dict[str, Any] = {"int_ior": index, **rough}
    if not inputs.is_constant("transmission_color", 1):
        pane["sigma_t"] = derived(
            inputs, ("transmission_color",), lambda c: 2 * optical_depth(c, DRJIT), color=True
        )
    if coat is None:
        return pane | {"ext_ior": 1.0}
    below = {name: value for name, value in coat.items() if name != "ext_ior"}
    # Mitsuba refuses equal indices.
    far = glass | width_properties(inputs, "coat") | {"int_ior": AIR * (1 + 1e-5)}
    pane |= {"type": "layered", "base": below | {"type": "layered", "base": far}}
    return coat | {"base": pane}
