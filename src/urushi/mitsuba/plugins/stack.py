"""A stack of coats over a Mitsuba BSDF, in the form that the random walk and its proposal take.

The proposal represents the BSDF below by lobes.
"""

import functools
import operator
from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi import checks
from urushi.checks import CoatParameters, Widths
from urushi.core import fresnel, microfacet
from urushi.core.microfacet import of_widths
from urushi.core.mixture import Mixture
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import SlabMixture
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import CoatTextures, alpha_of
from urushi.mitsuba.recording import opaque
from urushi.walk.bottoms.dielectric import Reflector

#: Samples from which a bottom's lobes are estimated.
SAMPLES = 1 << 14

#: Ratio of a bottom lobe's two widths from which its lobe in a proposal has both. The estimate of
#: the ratio has a standard error of about 2 %.
ANISOTROPIC_RATIO = 1.25

#: Least share of light in quantiles: light of no share at all has some, too.
LEAST_SHARE = 1e-30

#: Smallest unnormalised weights of a lobe and of the cosine lobe in a proposal.
MIN_SHARE, MIN_COSINE_SHARE = 0.02, 0.1


class BottomLobes:
    """Two GGX lobes and the directional albedo of a BSDF at normal incidence, by sampling it.

    For a GGX reflector and wi at the normal, the share q of samples with tan theta_h below t is
    q = t^2 / (alpha^2 + t^2), so that alpha follows from any quantile. The first and the third
    quartile of another BSDF give a narrow and a wide lobe. Along one axis, the share with
    |h.x / h.z| below t is q = t / sqrt(alpha_u^2 + t^2), from which follow the widths of an
    anisotropic lobe.
    """

    def __init__(self, bsdf: "mi.BSDF"):
        rng = mi.PCG32(size=SAMPLES)
        uv = np.random.default_rng(0).random((SAMPLES, 2), np.float32)
        si = probing.interaction(np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)), uv)
        u = mi.Point2f(rng.next_float32(), rng.next_float32())
        bs, weight = bsdf.sample(mi.BSDFContext(), si, rng.next_float32(), u)
        valid = (bs.pdf > 0) & (bs.wo.z > 0)
        half = bs.wo + mi.Vector3f(0, 0, 1)
        tangent = (dr.hypot(half.x, half.y) / half.z).numpy()
        share = np.nan_to_num(np.where(valid.numpy(), dr.mean(weight).numpy(), 0), posinf=0)
        self.albedo = opaque(min(share.sum() / SAMPLES, 1))
        self._alphas = []  # of each lobe, one width or two
        slopes = np.abs(np.stack([(half.x / half.z).numpy(), (half.y / half.z).numpy()]))
        for q in (0.25, 0.75):
            found = quantiles(slopes, share, [q])[:, 0] * ((1 - q * q) ** 0.5 / q)
            if found.max() < ANISOTROPIC_RATIO * found.min():
                found = quantiles(tangent, share, [q]) * ((1 - q) / q) ** 0.5
            self._alphas.append([opaque(float(width)) for width in found])

    @property
    def alphas(self) -> list[Any]:
        """The widths of the two lobes, `Widths` of those that are anisotropic."""
        return [alpha_of(alpha) for alpha in self._alphas]


def quantiles(tangents: np.ndarray, shares: np.ndarray, q: Sequence[float]) -> np.ndarray:
    """The q-quantiles (..., Q) of tangents (..., M) of shares (..., M) or (M,) of light.

    Where there is no light, all tangents count alike.
    """
    weights = np.maximum(shares, LEAST_SHARE)
    found = np.quantile(tangents, q, axis=-1, weights=weights, method="inverted_cdf")
    return np.moveaxis(found, 0, -1)


class CoatStack:
    """Coats at a surface interaction, top to bottom; see `urushi.walk.walk.Layers`.

    A walk needs single numbers for widths and indices. If a width is coloured, the coats of one
    channel are a stack of their own.
    """

    def __init__(self, parameters: Sequence[CoatTextures], si, active, channel: int | None = None):
        """Evaluate the coats; channel: the only one of the spectrum's that is kept, if not None."""
        self.count = len(parameters)
        values = [coat.evaluate(si, active) for coat in parameters]
        if channel is not None:
            values = [CoatParameters(*(_at_channel(x, channel) for x in coat)) for coat in values]
        if any(coat.is_anisotropic for coat in parameters):
            values = [value._replace(alpha=_two_widths(value.alpha)) for value in values]
        self._coats = [_clipped(value) for value in values]

    def interface(self, index):
        """(alpha, eta) of an interface; eta is relative to the medium above.

        alpha is `Widths` if one of the coats is anisotropic.
        """
        return self._at(index, "alpha"), self._at(index, "eta")

    def medium(self, index):
        """(albedo, sigma_t, g) of the medium under that interface."""
        return tuple(self._at(index, name) for name in ("albedo", "sigma_t", "g"))

    def proposal(self, bottom: BottomLobes, cos_i) -> Mixture:
        """A proposal: one lobe for each interface, two for the bottom, and a cosine lobe."""
        return _proposal(self._coats, bottom.alphas, bottom.albedo, cos_i)

    def lowest(self, index, alpha=None) -> Reflector:
        """The lower interface of a slab.

        Args:
            index: of what lies beyond, relative to the medium above the slab.
            alpha: its width or `Widths`; None: as wide as the lowest coat's.
        """
        if alpha is None:
            alpha = self._coats[-1].alpha
        eta = index / functools.reduce(operator.mul, (coat.eta for coat in self._coats))
        return Reflector(_width_in_range(alpha), _index_in_range(eta, checks.LEAST_ETA_BELOW))

    def slab_proposal(self, wi, lowest: Reflector) -> SlabMixture:
        """A proposal for both sides of a slab over its lowest interface.

        Light from below is reflected by the stack turned upside down. A facet tilts light that goes
        through as a mirror of half the step of the index does.
        """
        cosine, index, spread, depth = dr.abs(wi.z), mi.Float(1), mi.Float(0), mi.Float(0)
        interfaces = [*((coat.alpha, coat.eta) for coat in self._coats), (lowest.alpha, lowest.eta)]
        for alpha, eta in interfaces:
            width = sum(map(spectrum.mean, microfacet.pair(alpha))) / 2
            spread += dr.square(0.5 * index * (eta - 1) * width)
            index = index * eta
        for coat in self._coats:
            depth += spectrum.mean(coat.sigma_t)
        across = dr.select(wi.z > 0, index, 1 / index)
        reflectance, _ = fresnel.dielectric(cosine, across)

        def seen(above, below):
            return of_widths(lambda a, b: dr.select(wi.z > 0, a, b), above, below)

        turned = [
            coat._replace(alpha=alpha, eta=1 / eta)
            for coat, (alpha, eta) in zip(self._coats[::-1], interfaces[:0:-1], strict=True)
        ]
        pairs = zip(self._coats, turned, strict=True)
        facing = [CoatParameters(*map(seen, *pair)) for pair in pairs]
        far = seen(lowest.alpha, interfaces[0][0])
        first, _ = fresnel.dielectric(cosine, facing[0].eta)
        straight = MIN_COSINE_SHARE + dr.exp(-depth / dr.maximum(cosine, 0.3))
        scale = 1 / (1.75 + straight)
        narrow = dr.clip(dr.sqrt(spread) / dr.select(wi.z > 0, index, 1), checks.MIN_ALPHA / 4, 1)
        wide = dr.minimum(4 * narrow, 1)
        passed = Mixture([scale * straight, scale, 0.75 * scale], [narrow, wide])
        mixture = _proposal(facing, channel_widths(far), 1.0, cosine)
        return SlabMixture(mixture, passed, 0.25 + 0.5 * dr.maximum(first, reflectance), across)

    def _at(self, index, name: str):
        """The parameter of that name of a coat."""
        result, *others = (getattr(coat, name) for coat in self._coats)
        for i, value in enumerate(others, 1):
            result = dr.select(index == i, value, result)
        return result


def _proposal(coats: Sequence[CoatParameters], alphas: Sequence, albedo, cos_i) -> Mixture:
    """A proposal of coats over the lobes of what lies below, of the widths `alphas`.

    Lobes from below are widened by refraction at the interfaces above and by their roughness: a
    heuristic, which affects the noise only, not the mean.
    """
    reached, diffuse = mi.Float(1), mi.Float(MIN_COSINE_SHARE)
    stretch, blur = mi.Float(1), mi.Float(0)  # alpha^2 outside = stretch alpha^2 + blur
    found, shares = [], []
    for coat in coats:
        eta, widths = coat.eta, channel_widths(coat.alpha)
        reflectance, cos_t = fresnel.dielectric(cos_i, eta)
        share = reached * reflectance + MIN_SHARE
        for alpha in widths:
            found.append(_width_outside(alpha, stretch, blur))
            shares.append(share if len(widths) == 1 else share / len(widths))
        passed = dr.exp(-spectrum.mean(coat.sigma_t) * (2 / dr.maximum(cos_t, 0.1)))
        reached = reached * (1 - reflectance)
        diffuse += reached * (1 - passed) * spectrum.mean(coat.albedo)
        reached = reached * passed
        cos_i = cos_t
        mean = widths[0] if len(widths) == 1 else of_widths(spectrum.mean, coat.alpha)
        more = of_widths(
            lambda x, eta=eta, scale=stretch * 2: scale * dr.square((eta - 1) * x), mean
        )
        blur = of_widths(operator.add, blur, more)
        stretch *= eta * eta
    for alpha in alphas:
        found.append(_width_outside(alpha, stretch, blur))
        shares.append(reached * (0.5 * albedo) + MIN_SHARE)
    if any(isinstance(alpha, Widths) for alpha in found):
        found = [_two_widths(alpha) for alpha in found]
    shares.append(diffuse)
    scale = 1 / sum(shares)
    return Mixture([share * scale for share in shares], found)


class MitsubaBottom:
    """A Mitsuba BSDF at a surface interaction; see `urushi.walk.bottoms.bottom.Bottom`.

    channel: the only one of the spectrum's that is kept, if not None.
    """

    def __init__(self, bsdf: "mi.BSDF", ctx, si, active, channel: int | None = None):
        self._bsdf, self._si, self._active, self._channel = bsdf, si, active, channel
        self._ctx = mi.BSDFContext(ctx.mode)

    def f_pdf(self, wi, wo):
        """BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon."""
        valid = self._active & (wi.z > 0) & (wo.z > 0)
        f_cos, pdf = self._bsdf.eval_pdf(self._ctx, self._interaction(wi), wo, valid)
        return dr.select(valid, self._kept(f_cos) / wo.z, 0), dr.select(valid, pdf, 0)

    def sample(self, wi, u0, u1, u2):
        """Draw wo; returns (wo, f cos / pdf, pdf), weight 0 on failure."""
        valid = self._active & (wi.z > 0)
        si, u = self._interaction(wi), mi.Point2f(u1, u2)
        bs, weight = self._bsdf.sample(self._ctx, si, u0, u, valid)
        valid &= (bs.wo.z > 0) & (bs.pdf > 0)
        return bs.wo, dr.select(valid, self._kept(weight), 0), dr.select(valid, bs.pdf, 0)

    def _kept(self, value):
        return value if self._channel is None else value[self._channel]

    def _interaction(self, wi):
        si = mi.SurfaceInteraction3f(self._si)
        si.wi = wi
        return si


def _clipped(coat: CoatParameters) -> CoatParameters:
    """Parameters clipped to their ranges: filters and spectra may leave them."""
    return CoatParameters(
        _width_in_range(coat.alpha),
        _index_in_range(coat.eta),
        dr.clip(coat.albedo, 0, 1),
        dr.maximum(coat.sigma_t, 0),
        dr.clip(coat.g, -0.999, 0.999),
    )


def _width_in_range(alpha: Any) -> Any:
    return of_widths(lambda alpha: dr.clip(alpha, checks.MIN_ALPHA, 1), alpha)


def _index_in_range(eta: Any, low: float = checks.ETA_RANGE[0]) -> Any:
    """A relative index clipped to [low, 3]. A filter may cross 1, near which an index is 1."""
    return dr.select(
        dr.abs(eta - 1) < checks.MIN_INDEX_STEP, 1, dr.clip(eta, low, checks.ETA_RANGE[1])
    )


def _width_outside(alpha, stretch, blur):
    """The width, seen from outside the stack, of a lobe of width alpha inside it."""
    return of_widths(
        lambda alpha, blur: dr.clip(dr.sqrt(stretch * alpha * alpha + blur), checks.MIN_ALPHA, 1),
        alpha,
        blur,
    )


def _at_channel(value: Any, channel: int) -> Any:
    """A channel of a spectrum; a number as it is."""
    return of_widths(lambda x: x[channel] if dr.depth_v(x) > 1 else x, value)


def channel_widths(alpha: Any) -> list[Any]:
    """The widths of a surface: one, or one for every channel if the widths are coloured."""
    if all(dr.depth_v(width) == 1 for width in microfacet.pair(alpha)):
        return [alpha]
    return [_at_channel(alpha, channel) for channel in range(dr.size_v(mi.Spectrum))]


def _two_widths(alpha: Any) -> Widths:
    """A width as two equal ones; two as they are."""
    return Widths(*microfacet.pair(alpha))
