"""A stack of coats over a Mitsuba BSDF, as the random walk and its sampling see them."""

from collections.abc import Sequence
from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.physics import fresnel
from urushi.physics.mixture import Mixture
from urushi.render.reading import probing
from urushi.render.reading.parameters import CoatParameters, CoatValues, opaque

#: Shares of the proposal that no lobe, and not the cosine lobe, falls below.
MIN_SHARE, MIN_COSINE_SHARE = 0.02, 0.1
#: A texture's filter may leave less of an index of refraction than the walk can refract by.
LEAST_ETA = 1.0001
#: Samples from which a bottom's lobes are estimated.
SAMPLES = 1 << 14


def walk_color() -> type:
    """The type of the walk's throughputs: a plain float where there is one channel."""
    return mi.Float if mi.is_monochromatic else mi.Spectrum


class Coats:
    """Coats at a surface interaction, top to bottom: `urushi.reference.walk.Layers`."""

    def __init__(self, parameters: Sequence[CoatParameters], si, active):
        self.count = len(parameters)
        values = [coat.evaluate(si, active) for coat in parameters]
        self._etas = [
            dr.clip(value.eta, LEAST_ETA, 3) if coat.has_textured_eta else value.eta
            for coat, value in zip(parameters, values, strict=True)
        ]
        self._coats = [_for_walk(value) for value in values]

    def interface(self, index):
        """(alpha, eta) of an interface; eta is relative to the medium above."""
        return self._at(index, [coat.alpha for coat in self._coats]), self._at(index, self._etas)

    def medium(self, index):
        """(albedo, sigma_t, g) of the medium under that interface."""
        return tuple(
            self._at(index, [getattr(coat, name) for coat in self._coats])
            for name in ("albedo", "sigma_t", "g")
        )

    def mixture(self, bottom: "BottomLobes", cos_i) -> Mixture:
        """A proposal that follows light down: one lobe an interface, two of the bottom, a cosine.

        Lobes from below are widened by the indices of refraction that they pass and by the
        roughness of the interfaces. Heuristic: it steers the noise, never the result.
        """
        reached, diffuse = mi.Float(1), mi.Float(MIN_COSINE_SHARE)
        stretch, blur = mi.Float(1), mi.Float(0)  # alpha^2 outside = stretch alpha^2 + blur
        alphas, shares = [], []
        for coat, eta in zip(self._coats, self._etas, strict=True):
            reflectance, cos_t = fresnel.dielectric(cos_i, eta)
            alphas.append(_outside(coat.alpha, stretch, blur))
            shares.append(reached * reflectance + MIN_SHARE)
            passed = dr.exp(-_mean(coat.sigma_t) * (2 / dr.maximum(cos_t, 0.1)))
            reached = reached * (1 - reflectance)
            diffuse += reached * (1 - passed) * _mean(coat.albedo)
            reached = reached * passed
            blur += stretch * 2 * dr.square((eta - 1) * coat.alpha)
            stretch *= eta * eta
            cos_i = cos_t
        for alpha in bottom.alphas:
            alphas.append(_outside(alpha, stretch, blur))
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
    """A Mitsuba BSDF at a surface interaction, as `urushi.reference.bottoms.Bottom`."""

    def __init__(self, bsdf: "mi.BSDF", ctx, si, active):
        self._bsdf, self._si, self._active = bsdf, si, active
        self._ctx = mi.BSDFContext(ctx.mode)

    def f_pdf(self, wi, wo):
        """BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon."""
        valid = self._active & (wi.z > 0) & (wo.z > 0)
        f_cos, pdf = self._bsdf.eval_pdf(self._ctx, self._seen_from(wi), wo, valid)
        return dr.select(valid, _color(f_cos) / wo.z, 0), dr.select(valid, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        """Draw wo; returns (wo, f cos / pdf, pdf), weight 0 on failure."""
        valid = self._active & (wi.z > 0)
        si, u = self._seen_from(wi), mi.Point2f(u1, u2)
        bs, weight = self._bsdf.sample(self._ctx, si, u0, u, valid)
        valid &= (bs.wo.z > 0) & (bs.pdf > 0)
        return bs.wo, dr.select(valid, _color(weight), 0), dr.select(valid, bs.pdf, 0)

    def _seen_from(self, wi):
        si = mi.SurfaceInteraction3f(self._si)
        si.wi = wi
        return si


class BottomLobes:
    """How wide a BSDF reflects: two GGX widths and the albedo, at normal incidence.

    Of a GGX reflector seen from the normal, the share q of samples with tan theta_h below t obeys
    q = t^2 / (alpha^2 + t^2), so that every quantile tells alpha; of another BSDF, the quartiles
    tell a narrow and a wide lobe.
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
    """The GGX width that the q-quantile tells; tangents ascending, with the shares below them."""
    if below[-1] == 0:
        return 0.5  # black: any width will do
    return float(tangent[np.searchsorted(below, q * below[-1])] * ((1 - q) / q) ** 0.5)


def _for_walk(coat: CoatValues) -> CoatValues:
    """Parameters within their ranges, whatever a texture's filter or spectrum made of them."""
    return CoatValues(
        dr.clip(coat.alpha, 0.01, 1),
        coat.eta,
        dr.clip(_color(coat.albedo), 0, 1),
        dr.maximum(_color(coat.sigma_t), 0),
        dr.clip(_color(coat.g), -0.999, 0.999),
    )


def _outside(alpha, stretch, blur):
    """The width outside the stack of a lobe of width alpha inside it."""
    return dr.clip(dr.sqrt(stretch * alpha * alpha + blur), 0.01, 1)


def _color(value):
    return value[0] if mi.is_monochromatic else value


def _mean(value):
    return value if mi.is_monochromatic else dr.mean(value)
