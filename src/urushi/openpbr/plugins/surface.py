"""The surface of OpenPBR: base, coated base and fuzz, mixed by their weights."""

from collections.abc import Callable
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.mitsuba.latents.holders import tabulated
from urushi.mitsuba.plugins.coats import Turn, TurnedMixture
from urushi.openpbr import medium, sheen
from urushi.openpbr.inputs import Inputs
from urushi.openpbr.plugins.compensation import Compensation

#: Share of the fuzz and of the coat's compensation in what is sampled.
DIFFUSE_SHARE = 0.1


#: The parameters that the surface reads itself.
OWN = ("coat_weight", "fuzz_weight", "fuzz_color", "fuzz_roughness")

#: Those of layers, which may be left out as long as the parameters have their defaults.
OF_LAYERS = (
    *("coat_color", "coat_roughness", "coat_roughness_anisotropy", "coat_ior", "coat_darkening"),
    *("thin_film_weight", "thin_film_thickness", "thin_film_ior"),
)


class Part(NamedTuple):
    """A BSDF at a vertex.

    Attributes:
        bsdf: of `base.define_proposal_bsdf`.
        vertex: its own.
        weight: its weight in the mixture.
    """

    bsdf: Any
    vertex: Any
    weight: Any


class Fuzz(NamedTuple):
    """The fuzz at a vertex.

    Attributes:
        hidden: fuzz_weight times the albedo seen from wi.
        color: fuzz_color. roughness: fuzz_roughness.
    """

    hidden: Any
    color: Any
    roughness: Any


class Layers(NamedTuple):
    """What a surface consists of; None where the weights leave a part out.

    Attributes:
        base: in air; None where the coat covers everything.
        below: the base below the coat. coated: that base under the coat.
        compensation: gives back what a coated white base loses; None: nothing does.
        kind: what the coat has been made for.
    """

    base: Any
    below: Any
    coated: Any
    compensation: Compensation | None
    kind: Any


class Vertex(NamedTuple):
    """The surface at a vertex; see `Part` and `Fuzz`."""

    turn: Turn | None
    parts: list[Part]
    compensation: Any
    fuzz: Any


class SurfaceProposal(NamedTuple):
    """A mixture of proposals and a cosine lobe.

    Attributes:
        proposals: those of the parts, with their weights of sum one.
        diffuse: share of the cosine lobe.
    """

    proposals: list[tuple[Any, Any]]
    diffuse: float

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        density = sum(weight * proposal.pdf(wi, wo) for proposal, weight in self.proposals)
        return with_cosine(density, wo, self.diffuse)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        wo = mi.warp.square_to_cosine_hemisphere(u)
        rest, start = (choice - self.diffuse) / (1 - self.diffuse), mi.Float(0)
        for proposal, weight in self.proposals:
            chosen = (choice >= self.diffuse) & (rest >= start) & (weight > 0)
            own = dr.clip((rest - start) / dr.maximum(weight, 1e-6), 0, 0.99999994)
            wo = dr.select(chosen, proposal.sample(wi, own, u), wo)
            start = start + weight
        return wo


def with_cosine(density, wo, share: float):
    """A density mixed with a share of the cosine lobe's."""
    return (1 - share) * density + share * (wo.z * dr.inv_pi)


def define(base: type) -> type:
    """Make the class in the current variant; base: of `define_proposal_bsdf`."""

    class OpenPBRSurface(base):
        """Mixes BRDFs: (1 - coat_weight) base + coat_weight coated, and fuzz above both."""

        def __init__(self, inputs: Inputs, make: Callable[[Layers | None], Layers]):
            """Make the layers.

            make: returns the layers that the parameters need, and reuses previous ones that still
                fit.
            """
            super().__init__(mi.Properties("openpbr"))
            self._where = inputs.where
            self._inputs, self._make = inputs, make
            self._turned = "geometry_tangent" in inputs.maps
            self._renewed = False  # whether `mi.traverse` may have listed a former coat
            self._configure(make(None))
            self._kept.keep(self)

        def _configure(self, layers: Layers):
            """Take the layers."""
            self._layers, inputs = layers, self._inputs
            self._base, self._coated = layers.base, layers.coated
            self._compensation = layers.compensation
            self._fuzz = not inputs.is_constant("fuzz_weight", 0)
            # A coat without an interface, of index one, is its medium alone.
            no_interface = inputs.is_constant("coat_ior", 1) and self._coated is None
            self._absorbs = no_interface and not (
                inputs.is_constant("coat_weight", 0) or inputs.is_constant("coat_color", 1)
            )
            self._version = inputs.version

        @property
        def inputs(self) -> Inputs:
            """The parameters."""
            return self._inputs

        @property
        def coated(self):
            """The BSDF of the base under the coat; None without a coat."""
            return self._coated

        def _vertex(self, si, active):
            turn = None
            if self._turned:
                turn = Turn(*self._inputs.tangent(si, active))
                si = turn.interaction(si)
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
            fuzz = self._fuzz_at(si, active) if self._fuzz else None
            return Vertex(turn, parts, compensation, fuzz)

        def _f(self, vertex, ctx, si, wo, active):
            return self._f_and_pdf(vertex, ctx, si, wo, active)[0]

        def _f_and_pdf(self, vertex, ctx, si, wo, active):
            if vertex.turn:
                si, wo = vertex.turn.interaction(si), vertex.turn.inside(wo)
            f, pdf = mi.Spectrum(0), mi.Float(0)
            for part in vertex.parts:
                own, density = part.bsdf._f_and_pdf(part.vertex, ctx, si, wo, active)
                if part.bsdf is self._coated:
                    if self._coat_has_codes():
                        own = self._layers.below.below_coat(own, si, wo, active)
                    if self._compensation:
                        own = self._compensation.completed(vertex.compensation, own, wo)
                f += part.weight * own
                pdf += part.weight * density
            if self._absorbs:
                depth = medium.optical_depth(self._inputs.color("coat_color", si, active), dr)
                passed = dr.exp(-depth * (1 / si.wi.z + 1 / wo.z))
                weight = self._inputs.number("coat_weight", si, active)
                f *= dr.lerp(mi.Spectrum(1), passed, weight)
            if vertex.fuzz:
                f = _under_fuzz(vertex.fuzz, f, si, wo)
            return f, with_cosine(pdf, wo, self._diffuse_share())

        def _proposal(self, vertex, si, active):
            if vertex.turn:
                si = vertex.turn.interaction(si)
            proposals = [
                (part.bsdf._proposal(part.vertex, si, active), part.weight) for part in vertex.parts
            ]
            proposal = SurfaceProposal(proposals, self._diffuse_share())
            return TurnedMixture(proposal, vertex.turn) if vertex.turn else proposal

        def _coat_has_codes(self) -> bool:
            """Whether networks evaluate the coat, which know a film by one mean reflectance."""
            return tabulated(getattr(self._coated, "latents", None)) is None

        def _diffuse_share(self) -> float:
            """Share of cosine-distributed directions, beyond those of the parts."""
            return DIFFUSE_SHARE if self._fuzz or self._compensation else 0.0

        def _fuzz_at(self, si, active) -> Fuzz:
            """The fuzz at a surface interaction."""
            inputs = self._inputs
            rough = inputs.number("fuzz_roughness", si, active)
            hidden = inputs.number("fuzz_weight", si, active) * sheen.albedo(si.wi.z, rough, dr)
            return Fuzz(hidden, inputs.color("fuzz_color", si, active), rough)

        def traverse(self, callback):
            textures = self._inputs.textures
            for name in OWN:
                callback.put(name, textures[name], mi.ParamFlags.Differentiable)
            for name, part in (("base", self._base), ("coated", self._coated)):
                if part is not None:
                    callback.put(name, part, mi.ParamFlags.Differentiable)
            # Mitsuba lists a texture once. These are the ones that no layer has listed.
            for name in OF_LAYERS:
                callback.put(name, textures[name], mi.ParamFlags.Differentiable)

        def _update(self, keys):
            self._inputs.refresh()
            if keys and all(key.startswith("fuzz") for key in keys):
                if self._version != self._inputs.version:
                    self._configure(self._layers)
                return
            former, renewed = self._layers, self._version != self._inputs.version
            if renewed or (self._compensation and not self._compensation.is_current):
                self._configure(self._make(former))
                self._renewed |= former.coated is not self._coated
            # A coat has seen what has changed if it was listed, and nothing else has.
            seen = set(keys) == {"coated"} and not (renewed or self._renewed)
            if self._coated is former.coated is not None and not seen:
                self._coated.parameters_changed(["bottom"])

        def to_string(self):
            parts = "\n".join(f"{part}," for part in (self._base, self._coated) if part)
            return "OpenPBR[\n  " + parts.replace("\n", "\n  ") + "\n]"

    return OpenPBRSurface


def _under_fuzz(fuzz: Fuzz, f, si, wo):
    """Fuzz over f [1/sr]: it covers a fraction of the surface and transmits the rest.

    The specification's layering by the albedo of the direction that is seen.
    """
    across = wo.x * si.wi.x + wo.y * si.wi.y
    lobe = sheen.density(si.wi.z, wo.z, across, fuzz.roughness, dr)
    return f * (1 - fuzz.hidden) + fuzz.color * (fuzz.hidden * lobe)
