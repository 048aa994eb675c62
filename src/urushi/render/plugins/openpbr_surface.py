"""The surface of OpenPBR: base, coated base and fuzz, mixed by their weights."""

import drjit as dr
import mitsuba as mi

from urushi.openpbr_surface import sheen
from urushi.render.plugins.coats import Turn
from urushi.render.plugins.openpbr_compensation import Compensation
from urushi.render.reading.openpbr_inputs import Inputs

#: Share of the fuzz and of the coat's compensation in what is sampled.
DIFFUSE_SHARE = 0.1


def define() -> type:
    """Make the class in the current variant."""

    class OpenPBRSurface(mi.BSDF):
        """Mixes BRDFs: (1 - coat_weight) base + coat_weight coated, and fuzz above both."""

        def __init__(self, inputs: Inputs, base, coated, compensation: Compensation | None):
            """Take the parts.

            base: the base in air; None where the coat covers everything.
            coated: the base under the coat; None without a coat.
            compensation: gives back what a coated white base loses; None: nothing does.
            """
            mi.BSDF.__init__(self, mi.Properties("openpbr"))
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection
            self.m_components = [flags | mi.BSDFFlags.FrontSide]
            self.m_flags = self.m_components[0]
            self._inputs, self._base, self._coated = inputs, base, coated
            self._turned = "geometry_tangent" in inputs.maps
            self._fuzz = not inputs.is_constant("fuzz_weight", 0)
            self._compensation = compensation

        @property
        def inputs(self) -> Inputs:
            """The parameters."""
            return self._inputs

        @property
        def coated(self):
            """The BSDF of the base under the coat; None without a coat."""
            return self._coated

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx, si, wo, active=True):
            active = mi.Bool(active) & (si.wi.z > 0) & (wo.z > 0)
            if self._turned:
                turn = Turn(*self._inputs.tangent(si, active))
                si, wo = turn.interaction(si), turn.inside(wo)
            return self._eval_pdf(ctx, si, wo, active)

        def _eval_pdf(self, ctx, si, wo, active):
            """`eval_pdf` in the frame of the tangent."""
            f_cos, pdf = mi.Spectrum(0), mi.Float(0)
            for part, weight in self._parts(si, active):
                own, density = part.eval_pdf(ctx, si, wo, active)
                if self._compensation and part is self._coated:
                    own = self._compensation.completed(own, si, wo, active)
                f_cos += weight * own
                pdf += weight * density
            diffuse = self._diffuse_share()
            cosine = dr.maximum(wo.z, 0)
            if self._fuzz:
                f_cos = self._under_fuzz(f_cos, si, wo, active)
            pdf = (1 - diffuse) * pdf + diffuse * (cosine * dr.inv_pi)
            return dr.select(active, f_cos, 0), dr.select(active, pdf, 0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = mi.Bool(active) & (si.wi.z > 0)
            turn = None
            if self._turned:
                turn = Turn(*self._inputs.tangent(si, active))
                si = turn.interaction(si)
            diffuse = self._diffuse_share()
            bs = dr.zeros(mi.BSDFSample3f)
            is_diffuse = sample1 < diffuse
            wo = mi.warp.square_to_cosine_hemisphere(sample2)
            rest, start = (sample1 - diffuse) / (1 - diffuse), mi.Float(0)
            for part, weight in self._parts(si, active):
                chosen = ~is_diffuse & (rest >= start) & (weight > 0)
                u = dr.clip((rest - start) / dr.maximum(weight, 1e-6), 0, 0.99999994)
                own, _ = part.sample(ctx, si, u, sample2, active & chosen)
                wo = dr.select(chosen, own.wo, wo)
                start = start + weight
            bs.wo = turn.outside(wo) if turn else wo
            f_cos, bs.pdf = self._eval_pdf(ctx, si, wo, active & (wo.z > 0))
            bs.eta = 1
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = 0
            return bs, dr.select(bs.pdf > 0, f_cos / bs.pdf, 0)

        def _parts(self, si, active) -> list:
            """The BSDFs that there are and their weights, of sum one."""
            if self._coated is None:
                return [(self._base, mi.Float(1))]
            if self._base is None:
                return [(self._coated, mi.Float(1))]
            weight = self._coat_weight(si, active)
            return [(self._base, 1 - weight), (self._coated, weight)]

        def _coat_weight(self, si, active):
            return self._inputs.number("coat_weight", si, active)

        def _diffuse_share(self) -> float:
            """Share of cosine-distributed directions, beyond those of the parts."""
            return DIFFUSE_SHARE if self._fuzz or self._compensation else 0.0

        def _under_fuzz(self, f_cos, si, wo, active):
            """Fuzz over f cos: it covers a share of the surface, and passes what it reflects not.

            The specification's layering by the albedo of the direction that is seen.
            """
            inputs = self._inputs
            weight = inputs.number("fuzz_weight", si, active)
            rough = inputs.number("fuzz_roughness", si, active)
            sine = dr.sqrt(dr.maximum(si.wi.x * si.wi.x + si.wi.y * si.wi.y, 1e-12))
            along = (wo.x * si.wi.x + wo.y * si.wi.y) / sine
            across = (wo.y * si.wi.x - wo.x * si.wi.y) / sine
            albedo = sheen.albedo(si.wi.z, rough, dr)
            lobe = sheen.density(si.wi.z, along, across, wo.z, rough, dr)
            color = inputs.color("fuzz_color", si, active)
            return f_cos * (1 - weight * albedo) + color * (weight * albedo * lobe)

        def traverse(self, callback):
            names = ("coat_weight", "fuzz_weight", "fuzz_color", "fuzz_roughness")
            for name in names:
                callback.put(name, self._inputs.textures[name], mi.ParamFlags.Differentiable)
            for name, part in (("base", self._base), ("coated", self._coated)):
                if part is not None:
                    callback.put(name, part, mi.ParamFlags.Differentiable)

        def to_string(self):
            parts = "\n".join(f"{part}," for part in (self._base, self._coated) if part)
            return "OpenPBR[\n  " + parts.replace("\n", "\n  ") + "\n]"

    return OpenPBRSurface
