"""A stack of coats over a Mitsuba BSDF, in the form that the random walk and its proposal take."""

from collections.abc import Sequence
from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP, CoatParameters
from urushi.physics import fresnel
from urushi.physics.mixture import Mixture
from urushi.render.reading import probing
from urushi.render.reading.parameters import CoatTextures, opaque

#: Smallest unnormalised weights of a lobe and of the cosine lobe in a proposal.
MIN_SHARE, MIN_COSINE_SHARE = 0.02, 0.1
#: Samples from which a bottom's lobes are estimated.
SAMPLES = 1 << 14


def walk_color() -> type:
    """The type of the walk's throughputs: a plain float where there is one channel."""
    return mi.Float if mi.is_monochromatic else mi.Spectrum


class CoatStack:
    """Coats at a surface interaction, top to bottom; see `urushi.reference.walk.Layers`."""

    def __init__(self, parameters: Sequence[CoatTextures], si, active):
        self.count = len(parameters)
        values = [coat.evaluate(si, active) for coat in parameters]
        self._etas = [
            _clipped_eta(value.eta) if coat.has_textured_eta else value.eta
            for coat, value in zip(parameters, values, strict=True)
        ]
        self._coats = [_clipped(value) for value in values]

    def interface(self, index):
        """(alpha, eta) of an interface; eta is relative to the medium above."""
        return self._at(index, [coat.alpha for coat in self._coats]), self._at(index, self._etas)

    def medium(self, index):
        """(albedo, sigma_t, g) of the medium under that interface."""
        return tuple(
            self._at(index, [getattr(coat, name) for coat in self._coats])
            for name in ("albedo", "sigma_t", "g")
        )

    def proposal(self, bottom: "BottomLobes", cos_i) -> Mixture:
        """A proposal: one lobe for each interface, two for the bottom, and a cosine lobe.

        Lobes from below are widened by refraction at the interfaces above and by their roughness.
        A heuristic: it affects the noise only, not the mean.
        """
        reached, diffuse = mi.Float(1), mi.Float(MIN_COSINE_SHARE)
        stretch, blur = mi.Float(1), mi.Float(0)  # alpha^2 outside = stretch alpha^2 + blur
        alphas, shares = [], []
        for coat, eta in zip(self._coats, self._etas, strict=True):
            reflectance, cos_t = fresnel.dielectric(cos_i, eta)
            alphas.append(_width_outside(coat.alpha, stretch, blur))
            shares.append(reached * reflectance + MIN_SHARE)
            passed = dr.exp(-_mean(coat.sigma_t) * (2 / dr.maximum(cos_t, 0.1)))
            reached = reached * (1 - reflectance)
            diffuse += reached * (1 - passed) * _mean(coat.albedo)
            reached = reached * passed
            blur += stretch * 2 * dr.square((eta - 1) * coat.alpha)
            stretch *= eta * eta
            cos_i = cos_t
        for alpha in bottom.alphas:
            alphas.append(_width_outside(alpha, stretch, blur))
            shares.append(reached * (0.5 * bottom.albedo) + MIN_SHARE)
        shares.append(diffuse)
        scale = 1 / sum(shares)
        return Mixture([share * scale for share in shares], alphas)

    def _at(self, index, values):
        result = values[0]
        for i, value in enumerate(values[1:], 1):
            result = dr.select(index == i, value, result)
        return result


class MitsubaBottom:
    """A Mitsuba BSDF at a surface interaction; see `urushi.reference.bottoms.Bottom`."""

    def __init__(self, bsdf: "mi.BSDF", ctx, si, active):
        self._bsdf, self._si, self._active = bsdf, si, active
        self._ctx = mi.BSDFContext(ctx.mode)

    def f_pdf(self, wi, wo):
        """BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon."""
        valid = self._active & (wi.z > 0) & (wo.z > 0)
        f_cos, pdf = self._bsdf.eval_pdf(self._ctx, self._interaction(wi), wo, valid)
        return dr.select(valid, _color(f_cos) / wo.z, 0), dr.select(valid, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        """Draw wo; returns (wo, f cos / pdf, pdf), weight 0 on failure."""
        valid = self._active & (wi.z > 0)
        si, u = self._interaction(wi), mi.Point2f(u1, u2)
        bs, weight = self._bsdf.sample(self._ctx, si, u0, u, valid)
        valid &= (bs.wo.z > 0) & (bs.pdf > 0)
        return bs.wo, dr.select(valid, _color(weight), 0), dr.select(valid, bs.pdf, 0)

    def _interaction(self, wi):
        si = mi.SurfaceInteraction3f(self._si)
        si.wi = wi
        return si


class BottomLobes:
    """Two GGX widths and the directional albedo of a BSDF at normal incidence, by sampling it.

    For a GGX reflector and wi at the normal, the share q of samples with tan theta_h below t is
    q = t^2 / (alpha^2 + t^2), so that alpha follows from any quantile. The first and the third
    quartile of another BSDF give a narrow and a wide lobe.
    """

    DRJIT_STRUCT: ClassVar = {"albedo": object, "alphas": list}  # for frozen functions

    def __init__(self, bsdf: "mi.BSDF"):
        rng = mi.PCG32(size=SAMPLES)
        uv = np.random.default_rng(0).random((SAMPLES, 2), np.float32)
        si = probing.interaction(np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)), uv)
        u = mi.Point2f(rng.next_float32(), rng.next_float32())
        bs, weight = bsdf.sample(mi.BSDFContext(), si, rng.next_float32(), u)
        valid = (bs.pdf > 0) & (bs.wo.z > 0)
        half = bs.wo + mi.Vector3f(0, 0, 1)
        tangent = (dr.hypot(half.x, half.y) / half.z).numpy()
        share = np.where(valid.numpy(), _mean(_color(weight)).numpy(), 0)
        order = np.argsort(tangent)
        below = np.cumsum(share[order])
        self.albedo = opaque(min(below[-1] / SAMPLES, 1))
        self.alphas = [opaque(_width(tangent[order], below, q)) for q in (0.25, 0.75)]


def _width(tangent: np.ndarray, below: np.ndarray, q: float) -> float:
    """The GGX width from the q-quantile; tangents ascending, and the cumulative weights."""
    if below[-1] == 0:
        return 0.5  # black: the width does not matter
    return float(tangent[np.searchsorted(below, q * below[-1])] * ((1 - q) / q) ** 0.5)


def _clipped(coat: CoatParameters) -> CoatParameters:
    """Parameters clipped to their ranges: filters and spectra may leave them."""
    return CoatParameters(
        dr.clip(coat.alpha, MIN_ALPHA, 1),
        coat.eta,
        dr.clip(_color(coat.albedo), 0, 1),
        dr.maximum(_color(coat.sigma_t), 0),
        dr.clip(_color(coat.g), -0.999, 0.999),
    )


def _clipped_eta(eta):
    """An index clipped to its range, and pushed away from 1: a texture's filter may cross it."""
    step = dr.copysign(dr.maximum(dr.abs(eta - 1), MIN_INDEX_STEP), eta - 1)
    return dr.clip(1 + step, *ETA_RANGE)


def _width_outside(alpha, stretch, blur):
    """The width, seen from outside the stack, of a lobe of width alpha inside it."""
    return dr.clip(dr.sqrt(stretch * alpha * alpha + blur), MIN_ALPHA, 1)


def _color(value):
    return value[0] if mi.is_monochromatic else value


def _mean(value):
    return value if mi.is_monochromatic else dr.mean(value)
