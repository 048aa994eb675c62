"""Surfaces: what the plugins are, apart from Mitsuba, which sees each through one adapter.

A plugin is a class of `Surface` in Python alone. `bsdf_of` makes Mitsuba's BSDF that holds it.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, reduce
from operator import or_
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError
from urushi.measured.tabulated import MeasuredSurface
from urushi.mitsuba.frames import Place, Turn
from urushi.mitsuba.properties import check_names, describe
from urushi.mitsuba.recording import Recorded, VertexCache, opaque, signature_of
from urushi.mitsuba.snapshot import ParameterSnapshot

#: Samples of the directional albedo for denoisers, at fixed points.
ALBEDO_SAMPLES = 256


@dataclass(frozen=True)
class KnownSurface:
    """What is known of a BSDF besides its values; by default nothing. `si` is an interaction."""

    latents: Any = None  # its codes, of `mitsuba.latents`
    measured: MeasuredSurface | None = None  # the measurement that it renders
    # From si to the analytic lobes (`urushi.nets.lobe`): six Dr.Jit floats for each channel, seven
    # of an anisotropic BSDF; None if they are not known.
    lobes: Callable[[Any], list[list] | None] = lambda si: None
    lobe_only: bool = False  # whether it is its lobe and nothing else
    # The BSDF whose values a table holds where the codes have others; None: there is none.
    table_source: Callable[[], Any] = lambda: None
    rotated: bool = False  # whether its tangent is turned about the normal


class Surface(Recorded):
    """A surface that scatters light: f and a proposal, from which directions are drawn.

    Subclasses read their properties in `_load` and give f (`_f` or `_f_and_pdf`) and the proposal
    (`_proposal`), in the frame of `_turn`. A surface reflects light from above, unless a subclass
    calls `_transmit`. Those with parameters have `traverse`, and `_update` if they compute anything
    from them.
    """

    UNRECORDED: ClassVar[tuple[str, ...]] = ("_vertex_cache", "_snapshot", "_signature")

    PROPERTIES: ClassVar[tuple[str, ...]] = ()  # names; none: the maker has checked them
    _transmits = False
    _index: Any = 1.0  # below the surface, relative to that above it

    def __init__(self, props: "mi.Properties", where: str | None = None):
        """where: begins errors; None: the plugin's name."""
        self._where = where or describe(props)
        if self.PROPERTIES:
            check_names(props, self.PROPERTIES, self._where)
        self._load(props)
        self._begin()
        self._signature = signature_of(self)
        self._snapshot.keep(self)

    def _begin(self) -> None:
        """Forget what belongs to former states."""
        self._vertex_cache, self._snapshot = VertexCache(), ParameterSnapshot()

    def _load(self, props):
        """Read the properties."""

    def _transmit(self, index=None):
        """Scatter light from both sides to both; index: below relative to above, if not 1."""
        self._transmits, self._index = True, 1.0 if index is None else opaque(index)

    def _flags(self) -> list:
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
        other = copy.copy(self)
        other._begin()
        return other

    def known(self) -> KnownSurface:
        """What it tells a coat above it; parameters may change it."""
        return KnownSurface()

    def relative_to(self, coat: Any) -> "Surface":
        """The surface below the medium of a coat (see `reading.changed`), of the same textures.

        By default, it is the same there as in air.
        """
        return self

    def replaced(self, replacement: Callable) -> "mi.BSDF | None":
        """The BSDF with other textures, see `reading.changed`; None: textures cannot be replaced.

        replacement: from a texture to the one that replaces it.
        """
        return None

    def _turn(self, si, active) -> Turn | None:
        """The turn of its tangent about the normal; None: it is the shape's."""

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
        """f |cos wo|, a spectrum; this and the following are those of `mi.BSDF`."""
        at = self._at(ctx, si, active)
        lit = self._lit(at, ctx, wo)
        f = self._f(at.vertex, ctx, at.si, at.inside(wo), lit)
        self._vertex_cache.extend()
        return dr.select(lit, f * dr.abs(wo.z), 0)

    def pdf(self, ctx, si, wo, active=True):
        """The density of `sample` [1/sr]."""
        at = self._at(ctx, si, active)
        density = self._proposal(at.vertex, at.si, at.active).pdf(at.si.wi, at.inside(wo))
        return dr.select(self._lit(at, ctx, wo), density, 0)

    def eval_pdf(self, ctx, si, wo, active=True):
        """`eval` and `pdf`."""
        at = self._at(ctx, si, active)
        return self._f_cos_and_pdf(at, ctx, at.inside(wo))

    def sample(self, ctx, si, sample1, sample2, active=True):
        """A direction as a `BSDFSample3f`, and f |cos wo| over its density."""
        at = self._at(ctx, si, active)
        bs = dr.zeros(mi.BSDFSample3f)
        wo = self._proposal(at.vertex, at.si, at.active).sample(at.si.wi, sample1, sample2)
        f_cos, bs.pdf = self._f_cos_and_pdf(at, ctx, wo)
        bs.wo = at.outside(wo)
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

    def eval_null_transmission(self, si, active=True):
        """Transmittance of light that goes straight on."""
        return mi.Spectrum(0)

    def traverse(self, callback):
        """List the parameters for `mi.traverse`."""

    def parameters_changed(self, keys):
        """Follow a change of the parameters, or put former values back and refuse it."""
        if dr.flag(dr.JitFlag.FreezingScope):
            raise ParameterError(
                f"{self._where}: its parameters are updated inside a frozen function, whose "
                "replay would not repeat the update; call parameters.update() before the "
                "function"
            )
        with self._snapshot.restored_on_error(self):
            self._update(keys)
        self._signature = signature_of(self)

    def _update(self, keys):
        """Follow a change of the parameters that `traverse` lists."""

    def _at(self, ctx, si, active) -> Place:
        active = mi.Bool(active)

        def compute():
            enabled = active & self._faces(si.wi) & any(self._components(ctx))
            turn = self._turn(si, enabled)
            inside = si if turn is None else turn.interaction(si)
            return enabled, turn, self._vertex(inside, enabled)

        context = ctx.mode, ctx.type_mask, ctx.component
        enabled, turn, vertex = self._vertex_cache.get(context, si, active, compute)
        return Place(enabled, turn, si if turn is None else turn.interaction(si), vertex)

    def _f_cos_and_pdf(self, at, ctx, wo):
        """f |cos wo| and the density; wo is in the turned frame."""
        lit = self._lit(at, ctx, wo)
        f, pdf = self._f_and_pdf(at.vertex, ctx, at.si, wo, lit)
        self._vertex_cache.extend()
        return dr.select(lit, f * dr.abs(wo.z), 0), dr.select(lit, pdf, 0)

    def _components(self, ctx) -> list[bool]:
        """Whether a context asks for light that is reflected, and that is transmitted."""
        flags = mi.BSDFFlags
        kinds = [(flags.GlossyReflection, flags.DiffuseReflection)]
        if self._transmits:
            kinds.append((flags.GlossyTransmission, flags.DiffuseTransmission))
        return [any(ctx.is_enabled(x, i) for x in kind) for i, kind in enumerate(kinds)]

    def _lit(self, at, ctx, wo):
        """Lanes in which light along wo can be seen, and the context asks for it."""
        components, lit = self._components(ctx), at.active & self._faces(wo)
        return lit if all(components) else lit & ((at.si.wi.z * wo.z > 0) == components[0])

    def to_string(self) -> str:
        """A description."""
        return f"{type(self).__name__}[]"

    def __str__(self) -> str:
        return self.to_string()


def bsdf_of(surface: Surface, props: "mi.Properties | None" = None) -> "mi.BSDF":
    """Mitsuba's BSDF that is a surface, in the current variant.

    props: those that Mitsuba gives; None: another plugin makes it.
    """
    return _adapter(mi.variant())(surface, props or mi.Properties(type(surface).__name__))


def surface_of(bsdf: "mi.BSDF") -> Surface | None:
    """The surface that a BSDF is; None: it is another of Mitsuba's."""
    return bsdf if isinstance(bsdf, Surface) else getattr(bsdf, "surface", None)


#: Methods of `mi.BSDF` that are the surface's.
FORWARDED = (
    *("eval", "pdf", "eval_pdf", "sample", "eval_diffuse_reflectance", "eval_null_transmission"),
    *("traverse", "to_string"),
)


@cache
def _adapter(variant: str) -> type:
    """The class in a variant: `mi.BSDF` is another one in each."""

    class SurfaceBSDF(mi.BSDF):
        """Mitsuba's view of a surface. What Mitsuba does not ask for is the surface's own.

        Mitsuba evaluates every BSDF that it knows, also while another thread loads one: the surface
        is complete before `mi.BSDF.__init__` makes the BSDF known.
        """

        def __init__(self, surface: Surface, props: "mi.Properties"):
            self.surface = surface
            mi.BSDF.__init__(self, props)
            self._set_flags()

        def _set_flags(self) -> None:
            self.m_components = self.surface._flags()
            self.m_flags = reduce(or_, self.m_components)

        def __getattr__(self, name: str) -> Any:
            if name == "surface":  # not yet set
                raise AttributeError(name)
            return getattr(self.surface, name)

        def parameters_changed(self, keys):
            self.surface.parameters_changed(keys)
            self._set_flags()

        def class_name(self) -> str:
            return type(self.surface).__name__

    def forwarded(name: str) -> Callable:
        return lambda self, *args, **named: getattr(self.surface, name)(*args, **named)

    for name in FORWARDED:
        setattr(SurfaceBSDF, name, forwarded(name))
    return SurfaceBSDF
