"""Base classes of the plugins: a BSDF that samples a proposal, and one that has latent codes."""

from functools import reduce
from operator import or_
from typing import ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents
from urushi.mitsuba.latents.codes import ConstantLatents, Vertex
from urushi.mitsuba.plugins.coats import Turn, TurnedMixture, turned
from urushi.mitsuba.reading.kept import KeptParameters
from urushi.mitsuba.reading.offers import Offer
from urushi.mitsuba.reading.parameters import check_names, describe, opaque
from urushi.mitsuba.recording import VertexCache, signature_of
from urushi.nets import weights
from urushi.nets.weights import Model

#: Samples of the directional albedo for denoisers, at fixed points.
ALBEDO_SAMPLES = 256


def define_proposal_bsdf() -> type:
    """Make the class in the current variant."""

    class ProposalBSDF(mi.BSDF):
        """A BSDF; subclasses give f (`_f` or `_f_and_pdf`) and the proposal (`_proposal`).

        It reflects light from above, unless a subclass calls `_transmit`. Mitsuba evaluates every
        BSDF that it knows, also while another thread loads one: a subclass reads its parameters in
        `_load`, or before it calls `__init__`, which makes the BSDF known.
        """

        UNRECORDED: ClassVar = ("_vertex_cache", "_kept", "_signature")

        PROPERTIES: ClassVar[tuple[str, ...]] = ()  # names; none: the maker has checked them
        _transmits = False
        _index = 1.0  # below the surface, relative to that above it

        def __init__(self, props, where=None):
            """where: begins errors; None: the plugin's name."""
            self._where = where or describe(props)
            if self.PROPERTIES:
                check_names(props, self.PROPERTIES, self._where)
            self._load(props)
            self._vertex_cache, self._kept = VertexCache(), KeptParameters()
            self._signature = signature_of(self)
            mi.BSDF.__init__(self, props)
            self._set_flags()
            self._kept.keep(self)

        def _load(self, props):
            """Read the properties."""

        def _transmit(self, index=None):
            """Scatter light from both sides to both; index: below relative to above, if not 1."""
            self._transmits, self._index = True, 1.0 if index is None else opaque(index)

        def _set_flags(self):
            """Tell Mitsuba the components."""
            self.m_components = self._flags()
            self.m_flags = reduce(or_, self.m_components)

        def _flags(self):
            """Mitsuba's flags of the components."""
            flags = mi.BSDFFlags
            reflected = flags.GlossyReflection | flags.DiffuseReflection | flags.FrontSide
            if not self._transmits:
                return [reflected]
            passed = flags.GlossyTransmission | flags.DiffuseTransmission | flags.FrontSide
            if not isinstance(self._index, float):
                passed |= flags.NonSymmetric
            return [reflected | flags.BackSide, passed | flags.BackSide]

        def _index_across(self, wi):
            """The index on the side that light from wi is transmitted to, relative to wi's."""
            return dr.select(wi.z > 0, self._index, 1 / self._index)

        def _faces(self, w):
            """Whether light arrives along or leaves along w."""
            return (w.z != 0) if self._transmits else (w.z > 0)

        def _copy(self):
            """A copy that shares everything, for another medium above."""
            copy = type(self).__new__(type(self))
            copy.__dict__.update(self.__dict__)
            copy._vertex_cache, copy._kept = VertexCache(), KeptParameters()
            mi.BSDF.__init__(copy, mi.Properties(type(self).__name__))
            copy.m_components, copy.m_flags = self.m_components, self.m_flags
            return copy

        def offer(self):
            """What it tells a coat above it."""
            return Offer()

        def _vertex(self, si, active):
            """Quantities at si that `_f` and `_proposal` share; None unless a subclass has any."""

        def _f(self, vertex, ctx, si, wo, active):
            """f, a spectrum [1/sr], for si.wi and wo; `_faces` is true of both."""
            return self._f_and_pdf(vertex, ctx, si, wo, active)[0]

        def _proposal(self, vertex, si, active):
            """The proposal for si.wi: it has `pdf` and `sample`, as `core.mixture.Mixture`."""
            raise NotImplementedError

        def _f_and_pdf(self, vertex, ctx, si, wo, active):
            """`_f`, and the density of the proposal [1/sr]."""
            f = self._f(vertex, ctx, si, wo, active)
            return f, self._proposal(vertex, si, active).pdf(si.wi, wo)

        def eval(self, ctx, si, wo, active=True):
            active, vertex = self._active_vertex(ctx, si, active)
            lit = active & self._asked(ctx, si, wo)
            f = self._f(vertex, ctx, si, wo, lit)
            self._vertex_cache.extend()
            return dr.select(lit, f * dr.abs(wo.z), 0)

        def pdf(self, ctx, si, wo, active=True):
            active, vertex = self._active_vertex(ctx, si, active)
            density = self._proposal(vertex, si, active).pdf(si.wi, wo)
            return dr.select(active & self._asked(ctx, si, wo), density, 0)

        def eval_pdf(self, ctx, si, wo, active=True):
            active, vertex = self._active_vertex(ctx, si, active)
            return self._f_cos_and_pdf(vertex, ctx, si, wo, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active, vertex = self._active_vertex(ctx, si, active)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = self._proposal(vertex, si, active).sample(si.wi, sample1, sample2)
            f_cos, bs.pdf = self._f_cos_and_pdf(vertex, ctx, si, bs.wo, active)
            bs.eta = 1
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = 0
            if self._transmits:
                through = bs.wo.z * si.wi.z < 0
                bs.sampled_component = dr.select(through, mi.UInt32(1), 0)
                passed = mi.UInt32(+mi.BSDFFlags.GlossyTransmission)
                bs.sampled_type = dr.select(through, passed, bs.sampled_type)
                bs.eta = dr.select(through, self._index_across(si.wi), 1)
            return bs, dr.select(bs.pdf > 0, f_cos / bs.pdf, 0)

        def eval_diffuse_reflectance(self, si, active=True):
            """The directional albedo at si.wi, at most one: the `albedo` of Mitsuba's ``aov``."""

            def add(index, total):
                # Even points (Roberts 2018), the same everywhere: an estimate without noise.
                steps = (0.8191725134, 0.6710436067, 0.5497004779)
                place = mi.Float(index) + 0.5
                u = [place * step - dr.floor(place * step) for step in steps]
                ctx = mi.BSDFContext()
                _, weight = self.sample(ctx, si, u[0], mi.Point2f(u[1], u[2]), active)
                return index + 1, total + weight

            start = mi.UInt32(0), mi.Spectrum(0)
            _, total = dr.while_loop(start, lambda index, total: index < ALBEDO_SAMPLES, add)
            return dr.clip(total / ALBEDO_SAMPLES, 0, 1)

        def parameters_changed(self, keys):
            self._check_changeable()
            with self._kept.restored_on_error(self):
                self._update(keys)
            self._signature = signature_of(self)

        def _update(self, keys):
            """Follow a change of the parameters that `traverse` lists."""

        def _check_changeable(self):
            """Refuse, by a ParameterError, changes while a frozen function is recorded."""
            if dr.flag(dr.JitFlag.FreezingScope):
                raise ParameterError(
                    f"{self._where}: its parameters are updated inside a frozen function, whose "
                    "replay would not repeat the update; call parameters.update() before the "
                    "function"
                )

        def _active_vertex(self, ctx, si, active):
            """Lanes that the caller wants and whose wi is above the horizon; the vertex there."""
            active = mi.Bool(active)

            def compute():
                enabled = self._enabled(ctx, si, active)
                return enabled, self._vertex(si, enabled)

            context = ctx.mode, ctx.type_mask, ctx.component
            return self._vertex_cache.get(context, si, active, compute)

        def _f_cos_and_pdf(self, vertex, ctx, si, wo, active):
            lit = active & self._asked(ctx, si, wo)
            f, pdf = self._f_and_pdf(vertex, ctx, si, wo, lit)
            self._vertex_cache.extend()
            return dr.select(lit, f * dr.abs(wo.z), 0), dr.select(lit, pdf, 0)

        def _components(self, ctx) -> list[bool]:
            """Whether a context asks for light that is reflected, and that is transmitted."""
            flags = mi.BSDFFlags
            kinds = [(flags.GlossyReflection, flags.DiffuseReflection)]
            if self._transmits:
                kinds.append((flags.GlossyTransmission, flags.DiffuseTransmission))
            return [any(ctx.is_enabled(x, i) for x in kind) for i, kind in enumerate(kinds)]

        def _enabled(self, ctx, si, active):
            return mi.Bool(active) & self._faces(si.wi) & any(self._components(ctx))

        def _asked(self, ctx, si, wo):
            """Whether light along wo can be seen, and the context asks for it."""
            components = self._components(ctx)
            if all(components):
                return self._faces(wo)
            return self._faces(wo) & ((si.wi.z * wo.z > 0) == components[0])

    return ProposalBSDF


class PlacedVertex(NamedTuple):
    """The vertex of codes at a surface interaction."""

    turn: Turn | None  # of the tangent about the normal, if there is one
    vertex: Vertex  # of the codes, in the turned frame


def define_neural_bsdf(base: type) -> type:
    """Make the class in the current variant; base: of `define_proposal_bsdf`."""

    class NeuralBSDF(base):
        """A BRDF given by latent codes; subclasses set `model` and `latents`."""

        model: Model
        latents: ConstantLatents | AxisLatents
        _colors = False  # whether three channels are colours, see `spectrum.from_channels`

        def offer(self):
            return Offer(self.latents)

        def _turn(self, si, active) -> Turn | None:
            """The turn of the tangent, if there is one."""

        def _vertex(self, si, active):
            turn = self._turn(si, active)
            inside = si if turn is None else turn.interaction(si)
            return PlacedVertex(turn, self.latents.vertex(inside, active))

        def _f(self, vertex, ctx, si, wo, active):
            si, wo = turned(vertex.turn, si, wo)
            channels = self.latents.f(vertex.vertex, si, wo, active)
            return self._spectrum(channels, si)

        def _proposal(self, vertex, si, active):
            proposal = vertex.vertex.proposal
            return proposal if vertex.turn is None else TurnedMixture(proposal, vertex.turn)

        def _f_and_pdf(self, vertex, ctx, si, wo, active):
            si, wo = turned(vertex.turn, si, wo)
            channels, pdf = self.latents.f_and_pdf(vertex.vertex, si, wo, active)
            return self._spectrum(channels, si), pdf

        def _spectrum(self, channels, si):
            return spectrum.from_channels(channels, si.wavelengths, colors=self._colors)

    return NeuralBSDF


def ignore(props: "mi.Properties", *names: str) -> None:
    """Mark parameters of another plugin as used: Mitsuba refuses a scene with unused ones."""
    for name in names:
        if name in props:
            props.mark_queried(name)


def read_weights(props: "mi.Properties") -> Model | None:
    """The weights that the property `weights` names; None without it: shipped ones that fit."""
    name = props.get("weights", "")
    if not name:
        return None
    shipped = weights.DEFAULT, weights.ANISOTROPIC
    return weights.find(name if name in shipped else resolve(name))


def resolve(path: str) -> str:
    """Find a file as Mitsuba does: relative to the scene file, then to the working folder."""
    return str(mi.file_resolver().resolve(path))
