"""What all plugins share: a reflecting Mitsuba BSDF that samples a normalised mixture of lobes.

What `neural_brdf` and `neural_layered` share: a Mitsuba BSDF that evaluates latent codes.
"""

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.latents.holders import ConstantLatents, TexturedLatents
from urushi.render.plugins.vertex_cache import VertexCache
from urushi.render.reading.parameters import describe


def define_mixture_bsdf() -> type:
    """Make the class in the current variant."""

    class MixtureBSDF(mi.BSDF):
        """Subclasses say what is evaluated (`_f`) and what is sampled (`_mixture`)."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection
            self.m_components = [flags | mi.BSDFFlags.FrontSide]
            self.m_flags = self.m_components[0]
            self._where = describe(props)  # begins errors
            self._recent = VertexCache()

        def _vertex(self, si, lit):
            """What evaluating and sampling at si share: nothing, unless a subclass says so."""

        def _f(self, vertex, ctx, si, wo, active):
            """The BRDF, a spectrum [1/sr], for si.wi and wo above the horizon."""
            raise NotImplementedError

        def _mixture(self, vertex, si, lit):
            """The proposal for si.wi, a `networks.twins.Mixture`."""
            raise NotImplementedError

        def eval(self, ctx, si, wo, active=True):
            lit, vertex = self._seen(ctx, si, active)
            return self._f_cos(vertex, ctx, si, wo, lit)

        def pdf(self, ctx, si, wo, active=True):
            lit, vertex = self._seen(ctx, si, active)
            return self._density(self._mixture(vertex, si, lit), si, wo, lit)

        def eval_pdf(self, ctx, si, wo, active=True):
            lit, vertex = self._seen(ctx, si, active)
            density = self._density(self._mixture(vertex, si, lit), si, wo, lit)
            return self._f_cos(vertex, ctx, si, wo, lit), density

        def sample(self, ctx, si, sample1, sample2, active=True):
            lit, vertex = self._seen(ctx, si, active)
            mixture = self._mixture(vertex, si, lit)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = mixture.sample(si.wi, sample1, sample2)
            bs.pdf = self._density(mixture, si, bs.wo, lit)
            bs.eta = 1
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = 0
            drawn = bs.pdf > 0
            f_cos = self._f_cos(vertex, ctx, si, bs.wo, drawn)
            return bs, dr.select(drawn, f_cos / bs.pdf, 0)

        def _check_changeable(self):
            """Refuse changes that are made while a frozen function is recorded.

            Raises:
                ParameterError: this is one.
            """
            if dr.flag(dr.JitFlag.FreezingScope):
                raise ParameterError(
                    f"{self._where}: its parameters are updated inside a frozen function, which "
                    "would not do again what a change takes; call parameters.update() before it"
                )

        def _seen(self, ctx, si, active):
            """Lanes that are wanted and whose wi is above the horizon, and the vertex there."""
            active = mi.Bool(active)

            def look():
                lit = self._lit(ctx, si, active)
                return lit, self._vertex(si, lit)

            question = (*si.wi, *si.uv, *si.duv_dx, *si.duv_dy, active)
            return self._recent.answer(question, look)

        def _f_cos(self, vertex, ctx, si, wo, lit):
            above = lit & (wo.z > 0)
            f_cos = dr.select(above, self._f(vertex, ctx, si, wo, above) * wo.z, 0)
            self._recent.extend()
            return f_cos

        def _density(self, mixture, si, wo, lit):
            return dr.select(lit & (wo.z > 0), mixture.pdf(si.wi, wo), 0)

        def _lit(self, ctx, si, active):
            """Lanes that the caller wants and whose wi is above the horizon."""
            glossy, diffuse = mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection
            wanted = ctx.is_enabled(glossy) or ctx.is_enabled(diffuse)
            return mi.Bool(active) & (si.wi.z > 0) & wanted

    return MixtureBSDF


def read_model(props: "mi.Properties") -> Model:
    """The networks that the property `weights` names, a shipped one or a file, else the default."""
    given = props.get("weights", weights.SHIPPED[0])
    return weights.find(given if given in weights.SHIPPED else resolve(given))


def resolve(path: str) -> str:
    """Find a file as Mitsuba does: relative to the scene file, then to the working folder."""
    return str(mi.file_resolver().resolve(path))


def define_neural_bsdf(base: type) -> type:
    """Make the class in the current variant; base: `mixture_bsdf.define`'s class."""

    class NeuralBSDF(base):
        """A BRDF given by latent codes; subclasses set `model` and `latents`."""

        model: Model
        latents: ConstantLatents | TexturedLatents

        def save(self, path):
            """Write the codes to a file that ``neural_brdf`` loads, textured or not.

            Raises:
                FileError: it cannot be written.
            """
            self.latents.save(path)

        def _vertex(self, si, active):
            return self.latents.vertex(si, active)

        def _f(self, vertex, ctx, si, wo, active):
            channels = self.latents.f(vertex, si, wo, active)
            return spectrum.from_channels(channels, si.wavelengths)

        def _mixture(self, vertex, si, active):
            return vertex.mixture

    return NeuralBSDF
