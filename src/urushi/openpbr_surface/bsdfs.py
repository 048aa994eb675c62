"""BSDFs of several layers, and that of an opaque surface: base, coated base and fuzz."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.frames import above_surface, raised, with_far_side
from urushi.mitsuba.reading.probing import known_surface
from urushi.mitsuba.surface import KnownSurface, bsdf_of
from urushi.openpbr_surface import formulas, model, parts
from urushi.openpbr_surface.compensation import Compensation
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parameters import names_of

#: Directions of light that has met several facets: one half evenly, the other by the cosine.
SPREAD = Mixture([0.5, 0.5], [1.0])

#: Share of the proposal for the coat's compensation.
LOST_SHARE = 0.1

#: The parameters of the coat.
OF_COAT = ("coat_color", "coat_roughness", "coat_roughness_anisotropy", "coat_ior")


class SurfaceProposal(NamedTuple):
    """A mixture of proposals."""

    proposals: list[tuple[Any, Any]]  # each with its weight; the weights sum to one

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        return sum(weight * proposal.pdf(wi, wo) for proposal, weight in self.proposals)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        wo, start = mi.Vector3f(0), mi.Float(0)
        for proposal, weight in self.proposals:
            chosen = (choice >= start) & (weight > 0)
            own = dr.clip((choice - start) / dr.maximum(weight, 1e-6), 0, 0.99999994)
            wo = dr.select(chosen, proposal.sample(wi, own, u), wo)
            start = start + weight
        return wo


@dataclass(frozen=True)
class Layer:
    """What has a share of the surface. Dr.Jit does not look into named tuples for its BSDF."""

    bsdf: Any
    share: str | None = None  # of `Shares`; None: all of it
    coated: bool | None = None  # whether it has the coated or the bare part of it; None: all


class Blend(parts.OfInputs):
    """A mixture of BSDFs. In what transmits light, opaque ones look the same from both sides."""

    _layers: Sequence[Layer]

    def _weights(self, layers: Sequence[Layer], si, active) -> list:
        """The shares of layers at an interaction."""
        at = self._inputs.at(si, active)
        found = parts.shares(*at.of(*parts.SHARES))
        covered = {None: 1, True: at.coat_weight, False: 1 - at.coat_weight}
        return [
            mi.Float((getattr(found, layer.share) if layer.share else 1) * covered[layer.coated])
            for layer in layers
        ]

    def _turn(self, si, active):
        return self._inputs.turn(si, active)

    def _vertex(self, si, active) -> Any:
        """BSDFs, each with its own vertex and its weight."""
        bsdfs = [layer.bsdf for layer in self._layers]
        own = [bsdf._vertex(self._seen(bsdf, si), active) for bsdf in bsdfs]
        return [*zip(bsdfs, own, self._weights(self._layers, si, active), strict=True)]

    def _seen(self, bsdf, si):
        """The interaction as a BSDF has it."""
        return si if bsdf._transmits == self._transmits else above_surface(si)

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        f, pdf, near = mi.Spectrum(0), mi.Float(0), si.wi.z * wo.z > 0
        for bsdf, own, weight in vertex:
            if bsdf._transmits == self._transmits:
                value, density = bsdf._f_and_pdf(own, ctx, si, wo, active)
            else:
                seen = self._seen(bsdf, si), raised(wo), active & near
                found = bsdf._f_and_pdf(own, ctx, *seen)
                value, density = (dr.select(near, x, 0) for x in found)
            f += weight * value
            pdf += weight * density
        return f, pdf

    def _proposal(self, vertex, si, active):
        proposals = []
        for bsdf, own, weight in vertex:
            proposal = bsdf._proposal(own, self._seen(bsdf, si), active)
            if bsdf._transmits != self._transmits:
                proposal = with_far_side(proposal, 0.0)
            proposals.append((proposal, weight))
        return SurfaceProposal(proposals)

    def to_string(self):
        layers = ",\n".join(str(layer.bsdf) for layer in self._layers)
        return "OpenPBR[\n  " + layers.replace("\n", "\n  ") + "\n]"


class OpenPBRSurface(Blend):
    """Mixes BRDFs: (1 - coat_weight) base + coat_weight coated, and fuzz above both."""

    names = names_of("base", "specular", "coat", "thin_film", "fuzz")

    def _configure(self):
        """Make the layers that parameters need; None: the weights leave it out."""
        inputs = self._inputs
        # A coat of index one has no interface: it only absorbs, see `model.absorbed`.
        bare = inputs.is_constant("coat_weight", 0)
        flat = bare or inputs.is_constant("coat_ior", 1)
        self._compensation: Any = None  # with the coated base, whose energy it compensates
        base = coated = None
        below: Any = None
        if not flat:
            below, coated = self._coat(inputs)
            if self._coating.compensated:
                self._compensation = Compensation(
                    coated, inputs, self._coating.tables, lambda twin: self._coat(twin)[1]
                )
        if flat or not inputs.is_constant("coat_weight", 1):
            base = bsdf_of(model.Base(inputs, under_coat=False))
        self._base, self._below, self._coated = base, below, coated  # in air, in the coat, with it
        top = self._compensation or coated
        self._layers = [Layer(base or top)]
        if base and top:
            self._layers = [Layer(base, coated=False), Layer(top, coated=True)]
        self._absorbs = flat and not (bare or inputs.is_constant("coat_color", 1))
        self._fuzz = not inputs.is_constant("fuzz_weight", 0)
        self._is_current = True

    def _coat(self, inputs: Inputs) -> "tuple[mi.BSDF, mi.BSDF]":
        """The base under the coat, without it and with it."""
        below = bsdf_of(model.Base(inputs, under_coat=True))
        options = self._coating.options if self._coating.tables else {}
        plugin = {"type": parts.COATS[not self._coating.tables], "bottom": below}
        return below, parts.load_part(inputs, plugin | parts.coat_properties(inputs) | options)

    @property
    def _walks(self) -> bool:
        """Whether the coat is walks."""
        return self._coated is not None and known_surface(self._coated).latents is None

    def _vertex(self, si, active):
        at, fuzz = self._inputs.at(si, active), None
        if self._fuzz:
            fuzz = model.Fuzz(at.fuzz_weight, at.fuzz_color, at.fuzz_roughness)
        return super()._vertex(si, active), fuzz

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        layers, fuzz = vertex
        f, pdf = super()._f_and_pdf(layers, ctx, si, wo, active)
        if self._absorbs:
            f = model.absorbed(self._inputs, f, si, wo, active)
        if self._compensation:
            pdf = dr.lerp(pdf, SPREAD.pdf(si.wi, wo), LOST_SHARE)
        if fuzz:
            f = model.under_fuzz(fuzz, f, ctx, si, wo)
            pdf = dr.lerp(pdf, fuzz.pdf(si.wi, wo), fuzz.share(si.wi))
        return f, pdf

    def _proposal(self, vertex, si, active):
        layers, fuzz = vertex
        proposal = super()._proposal(layers, si, active)
        added = [(SPREAD, LOST_SHARE)] if self._compensation else []
        added += [(fuzz, fuzz.share(si.wi))] if fuzz else []
        for other, share in added:
            proposal = SurfaceProposal([(other, share), (proposal, 1 - share)])
        return proposal

    def known(self):
        inputs, turned = self._inputs, "geometry_tangent" in self._inputs.maps
        if self._fuzz or self._absorbs or turned:
            return KnownSurface()
        if not self._coated:
            return replace(known_surface(self._base), table_source=lambda: self)
        names = (f"{layer}_roughness_anisotropy" for layer in ("coat", "specular"))
        if self._walks or not all(inputs.is_constant(name, 0) for name in names):
            return KnownSurface()
        return KnownSurface(lobes=self._coat_lobes, table_source=lambda: self)

    def _coat_lobes(self, si) -> list[list]:
        """The lobes of the coat's interface, as of `model.Base.lobes`."""
        at, zero = self._inputs.at(si, mi.Bool(True)), mi.Float(0)
        index = formulas.interface_index(at.coat_ior, DRJIT)
        lobe = [at.widths("coat"), zero, zero, at.coat_weight, index, zero]
        return [lobe] * dr.size_v(mi.Spectrum)

    def replaced(self, replacement):
        return bsdf_of(type(self)(self._inputs.with_textures(replacement), self._coating))

    def traverse(self, callback):
        # Walks have no derivatives.
        self._inputs.traverse(callback, self.names, self.names if self._walks else ())
        if tangent := self._inputs.maps.get("geometry_tangent"):  # `normalmap` lists the normal
            callback.put("geometry_tangent", tangent, mi.ParamFlags.NonDifferentiable)

    def _update(self, keys):
        self._is_current &= not self._inputs.refresh()
        if keys and all(key.startswith("fuzz") for key in keys):
            self._fuzz = not self._inputs.is_constant("fuzz_weight", 0)
            self._is_current = True  # no layer depends on it
        elif not (self._is_current and (not self._compensation or self._compensation.is_current)):
            self._configure()
        elif self._coated is not None:
            base = not keys or not {*keys}.isdisjoint(self._below.names)
            self._coated.parameters_changed(["bottom"] if base else list(OF_COAT))
