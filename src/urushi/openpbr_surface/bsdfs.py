"""The BSDF of an opaque surface: base, coated base and fuzz."""

from dataclasses import replace
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.reading.probing import known_surface
from urushi.mitsuba.surface import KnownSurface, Surface, bsdf_of
from urushi.openpbr_surface import formulas, model
from urushi.openpbr_surface.compensation import Compensation
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parameters import names_of
from urushi.openpbr_surface.parts import COATS, Coating, coat_properties, load_part

#: Directions of light that has met several facets: one half evenly, the other by the cosine.
SPREAD = Mixture([0.5, 0.5], [1.0])

#: Share of the proposal for the coat's compensation.
LOST_SHARE = 0.1

#: Share of the proposal that fuzz leaves to what lies below, at the least.
LEAST_BELOW = 0.1

#: The parameters of the coat.
OF_COAT = ("coat_color", "coat_roughness", "coat_roughness_anisotropy", "coat_ior")


class Part(NamedTuple):
    """A BSDF at a vertex."""

    bsdf: Any  # of `mitsuba.surface.bsdf_of`
    vertex: Any  # its own
    weight: Any  # its weight in the mixture


class Vertex(NamedTuple):
    """The surface at a vertex; see `Part` and `model.Fuzz`."""

    parts: list[Part]
    compensation: Any
    fuzz: Any
    fuzz_share: Any  # of the proposal


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


class OpenPBRSurface(Surface):
    """Mixes BRDFs: (1 - coat_weight) base + coat_weight coated, and fuzz above both."""

    def __init__(self, inputs: Inputs, coating: Coating):
        self._inputs, self._coating = inputs, coating
        self._configure()
        super().__init__(mi.Properties("openpbr"), inputs.where)

    def _configure(self):
        """Make the layers that parameters need; None: the weights leave it out."""
        inputs = self._inputs
        base = coated = compensation = None
        below: Any = None
        # A coat of index one has no interface: it only absorbs, see `model.absorbed`.
        bare = inputs.is_constant("coat_weight", 0)
        flat = bare or inputs.is_constant("coat_ior", 1)
        if not flat:
            below = bsdf_of(model.Base(inputs, under_coat=True))
            if self._coating.compensated:
                compensation = Compensation(inputs, self._coating.tables, self._white_coat)
            coated = self._coat(inputs, below)
        if flat or not inputs.is_constant("coat_weight", 1):
            base = bsdf_of(model.Base(inputs, under_coat=False))
        self._base, self._below, self._coated = base, below, coated  # in air, in the coat, with it
        self._compensation = compensation  # of the energy that `_coated` loses
        self._absorbs = flat and not (bare or inputs.is_constant("coat_color", 1))
        self._find_fuzz()
        self._is_current = True

    def _coat(self, inputs: Inputs, below: "mi.BSDF") -> "mi.BSDF":
        options = self._coating.options if self._coating.tables else {}
        plugin = {"type": COATS[not self._coating.tables], "bottom": below}
        return load_part(inputs, plugin | coat_properties(inputs) | options)

    def _white_coat(self, inputs: Inputs) -> "mi.BSDF":
        return self._coat(inputs, bsdf_of(model.Base(inputs, under_coat=True)))

    @property
    def _walks(self) -> bool:
        """Whether the coat is walks."""
        return self._coated is not None and known_surface(self._coated).latents is None

    def _find_fuzz(self):
        self._fuzz = not self._inputs.is_constant("fuzz_weight", 0)

    def _turn(self, si, active):
        return self._inputs.turn(si, active)

    def _vertex(self, si, active):
        bsdfs = [part for part in (self._base, self._coated) if part is not None]
        weights: list[Any] = [mi.Float(1)]
        if len(bsdfs) == 2:
            weight = self._inputs.number("coat_weight", si, active)
            weights = [1 - weight, weight]
        parts = [
            Part(bsdf, bsdf._vertex(si, active), weight)
            for bsdf, weight in zip(bsdfs, weights, strict=True)
        ]
        compensation = self._compensation.vertex(si, active) if self._compensation else None
        fuzz = None
        if self._fuzz:
            weight, rough = (
                self._inputs.number(f"fuzz_{x}", si, active) for x in ("weight", "roughness")
            )
            fuzz = model.Fuzz(weight, self._inputs.color("fuzz_color", si, active), rough)
        share = dr.minimum(fuzz.hidden(si.wi), 1 - LEAST_BELOW) if fuzz else 0.0
        return Vertex(parts, compensation, fuzz, share)

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        f, pdf = mi.Spectrum(0), mi.Float(0)
        for part in vertex.parts:
            own, density = part.bsdf._f_and_pdf(part.vertex, ctx, si, wo, active)
            if part.bsdf is self._coated and self._compensation:
                own = self._compensation.with_lost_light(vertex.compensation, own, wo)
            f += part.weight * own
            pdf += part.weight * density
        if self._absorbs:
            f = model.absorbed(self._inputs, f, si, wo, active)
        if vertex.compensation:
            pdf = dr.lerp(pdf, SPREAD.pdf(si.wi, wo), LOST_SHARE)
        if vertex.fuzz:
            f = model.under_fuzz(vertex.fuzz, f, ctx, si, wo)
            pdf = dr.lerp(pdf, vertex.fuzz.pdf(si.wi, wo), vertex.fuzz_share)
        return f, pdf

    def _proposal(self, vertex, si, active):
        own = [(part.bsdf._proposal(part.vertex, si, active), part.weight) for part in vertex.parts]
        added = [(SPREAD, LOST_SHARE)] if vertex.compensation else []
        added += [(vertex.fuzz, vertex.fuzz_share)] if vertex.fuzz else []
        proposal = SurfaceProposal(own)
        for other, share in added:
            proposal = SurfaceProposal([(other, share), (proposal, 1 - share)])
        return proposal

    def known(self):
        inputs, turned = self._inputs, "geometry_tangent" in self._inputs.maps
        if self._fuzz or self._absorbs or turned:
            return KnownSurface()
        if not self._coated:
            return replace(known_surface(self._base), table_source=lambda: self)
        layers = "coat", "specular"
        if self._walks or not all(
            inputs.is_constant(f"{layer}_roughness_anisotropy", 0) for layer in layers
        ):
            return KnownSurface()
        return KnownSurface(lobes=self._coat_lobes, table_source=lambda: self)

    def _coat_lobes(self, si) -> list[list]:
        """The lobes of the coat's interface, as of `model.Base.lobes`."""
        inputs, active, zero = self._inputs, mi.Bool(True), mi.Float(0)
        index = formulas.interface_index(inputs.number("coat_ior", si, active), DRJIT)
        alpha, weight = inputs.widths("coat", si, active), inputs.number("coat_weight", si, active)
        lobe = [alpha, zero, zero, weight, index, zero]
        return [lobe] * dr.size_v(mi.Spectrum)

    def replaced(self, replacement):
        return bsdf_of(type(self)(self._inputs.with_textures(replacement), self._coating))

    #: The parameters that it reads.
    names = names_of("base", "specular", "coat", "thin_film", "fuzz")

    def traverse(self, callback):
        # Walks have no derivatives.
        self._inputs.traverse(callback, self.names, self.names if self._walks else ())
        if tangent := self._inputs.maps.get("geometry_tangent"):  # `normalmap` lists the normal
            callback.put("geometry_tangent", tangent, mi.ParamFlags.NonDifferentiable)

    def _update(self, keys):
        self._is_current &= not self._inputs.refresh()
        if keys and all(key.startswith("fuzz") for key in keys):
            self._find_fuzz()
            self._is_current = True  # no layer depends on it
        elif not (self._is_current and (not self._compensation or self._compensation.is_current)):
            self._configure()
        elif self._coated is not None:
            base = not keys or not {*keys}.isdisjoint(self._below.names)
            self._coated.parameters_changed(["bottom"] if base else list(OF_COAT))

    def to_string(self):
        parts = "\n".join(f"{part}," for part in (self._base, self._coated) if part)
        return "OpenPBR[\n  " + parts.replace("\n", "\n  ") + "\n]"
