"""What all plugins share: a reflecting Mitsuba BSDF that samples a normalised mixture of lobes."""

import drjit as dr
import mitsuba as mi


def define() -> type:
    """Make the class in the current variant."""

    class MixtureBSDF(mi.BSDF):
        """Subclasses say what is evaluated (`_f`) and what is sampled (`_mixture`)."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection
            self.m_components = [flags | mi.BSDFFlags.FrontSide]
            self.m_flags = self.m_components[0]

        def _f(self, ctx, si, wo, active):
            """The BRDF, a spectrum [1/sr], for si.wi and wo above the horizon."""
            raise NotImplementedError

        def _mixture(self, si, active):
            """The proposal for si.wi, a `twins.Mixture`."""
            raise NotImplementedError

        def eval(self, ctx, si, wo, active=True):
            active = self._lit(ctx, si, active) & (wo.z > 0)
            return dr.select(active, self._f(ctx, si, wo, active) * wo.z, 0)

        def pdf(self, ctx, si, wo, active=True):
            active = self._lit(ctx, si, active) & (wo.z > 0)
            return dr.select(active, self._mixture(si, active).pdf(si.wi, wo), 0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = self._lit(ctx, si, active)
            mixture = self._mixture(si, active)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = mixture.sample(si.wi, sample1, sample2)
            bs.pdf = mixture.pdf(si.wi, bs.wo)
            bs.eta = 1
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = 0
            active &= (bs.pdf > 0) & (bs.wo.z > 0)
            bs.pdf = dr.select(active, bs.pdf, 0)
            f_cos = self.eval(ctx, si, bs.wo, active)
            return bs, dr.select(active, f_cos / bs.pdf, 0)

        def _lit(self, ctx, si, active):
            """Lanes that the caller wants and whose wi is above the horizon."""
            glossy, diffuse = mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection
            wanted = ctx.is_enabled(glossy) or ctx.is_enabled(diffuse)
            return mi.Bool(active) & (si.wi.z > 0) & wanted

    return MixtureBSDF
