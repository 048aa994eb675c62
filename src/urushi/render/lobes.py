"""The sampling proposal in Dr.Jit: the twin of `nets.sampler` and `nets.lobes`.

A mixture of GGX reflection lobes and a cosine lobe, its weights and widths from the proposal
network; directions that fall below the horizon are mirrored up, so that the density is exactly
normalised over the upper hemisphere.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.features import MIN_ALPHA
from urushi.nets.sampler import MIN_COSINE_SHARE
from urushi.nets.weights import Model
from urushi.physics.frame import square_to_cosine_hemisphere
from urushi.render import hidden, network
from urushi.render.features import sampler_features


class Mixture(NamedTuple):
    """A proposal: weights (K+1, the last the cosine lobe's) that add up to 1, widths (K)."""

    weights: Sequence[Any]
    alphas: Sequence[Any]

    def pdf(self, wi, wo):
        """See `pdf` below."""
        return pdf(self, wi, wo)

    def sample(self, wi, choice, u):
        """See `sample` below."""
        return sample(self, wi, choice, u)


class Proposal:
    """Mixtures from a model's latent codes and the cosine of wi."""

    def __init__(self, model: Model, cooperative: bool | None = None):
        """cooperative: see `hidden.choose`."""
        params, activation = model.params, model.arch.activation
        self._rest = hidden.choose(params, "sampler", activation, cooperative)
        self._lobes = model.arch.lobes
        weight = model.params["sampler.0.weight"]
        self._from_latent = weight[: model.arch.latent]
        self._from_angle = weight[model.arch.latent :]
        self._bias = model.params["sampler.0.bias"]

    def first_layer(self, latent: np.ndarray) -> np.ndarray:
        """The latent's share of the first layer's pre-activation: (..., 32) -> (..., width)."""
        return latent @ self._from_latent + self._bias

    def of_first_layer(self, share: Sequence, cos_i) -> Mixture:
        """The mixture for wi of cosine cos_i; share: a list (width) of Dr.Jit floats."""
        first = network.dense(sampler_features(cos_i), self._from_angle, share)
        return self._mixture(self._rest(first))

    def of_latent(self, latent: Sequence, cos_i) -> Mixture:
        """The same from a latent code, a list (32) of Dr.Jit floats."""
        share = network.dense(latent, self._from_latent, self._bias.tolist())
        return self.of_first_layer(share, cos_i)

    def _mixture(self, output: Sequence) -> Mixture:
        k = self._lobes
        logits = output[: k + 1]
        largest = logits[0]
        for logit in logits[1:]:
            largest = dr.maximum(largest, logit)
        shares = [dr.exp(logit - largest) for logit in logits]
        scale = (1 - MIN_COSINE_SHARE) / sum(shares)
        weights = [share * scale for share in shares]
        weights[k] = weights[k] + MIN_COSINE_SHARE
        fractions = [1 / (1 + dr.exp(x)) for x in output[k + 1 :]]
        alphas = [dr.clip(dr.exp(float(np.log(MIN_ALPHA)) * x), MIN_ALPHA, 1) for x in fractions]
        return Mixture(weights, alphas)


def pdf(mixture: Mixture, wi, wo):
    """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""
    density = mixture.weights[-1] * (wo.z * dr.inv_pi)
    for weight, alpha in zip(mixture.weights[:-1], mixture.alphas, strict=True):
        density += weight * reflection_pdf(alpha, wi, wo)
    return dr.select((wi.z > 0) & (wo.z > 0), density, 0)


def reflection_pdf(alpha, wi, wo):
    """Density of `sample_reflection` at wo above the horizon [1/sr], the mirrored part included.

    D(h) / (2 (cos_i + root)) with Smith's shadowing in the root, see `nets.lobes.reflection_pdf`.
    """
    alpha2 = alpha * alpha
    x, y = wi.x + wo.x, wi.y + wo.y
    across = x * x + y * y
    up, down = wi.z + wo.z, wi.z - wo.z
    total = _scaled_ggx(alpha2, across, up)
    total += dr.select(down > 0, _scaled_ggx(alpha2, across, down), 0)
    root = dr.sqrt(alpha2 + (1 - alpha2) * (wi.z * wi.z))
    return total * (alpha2 * (0.5 * dr.inv_pi)) / (wi.z + root)


def _scaled_ggx(alpha2, across, z):
    """pi D(h) / alpha^2 of a half vector with |h_xy|^2 = across and h_z = z."""
    ratio = (across + z * z) / dr.maximum(across + alpha2 * (z * z), 1e-30)
    return ratio * ratio


def sample(mixture: Mixture, wi, choice, u):
    """Draw wo above the horizon by the uniform numbers `choice` and `u` (two)."""
    edge, alpha = mixture.weights[0], mixture.alphas[0]
    for weight, next_alpha in zip(mixture.weights[1:-1], mixture.alphas[1:], strict=True):
        alpha = dr.select(choice >= edge, next_alpha, alpha)
        edge = edge + weight
    cosine = square_to_cosine_hemisphere(mi.Vector3f, u.x, u.y)
    return dr.select(choice >= edge, cosine, sample_reflection(alpha, wi, u.x, u.y))


def sample_reflection(alpha, wi, u1, u2):
    """Reflect wi about a visible GGX normal and mirror it up; density `reflection_pdf`.

    The normal by a spherical cap (Dupuy and Benyoub 2023, listing 1).
    """
    stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    sin_phi, cos_phi = dr.sincos(2 * dr.pi * u1)
    cap_z = (1 - u2) * (1 + stretched.z) - stretched.z
    cap_r = dr.safe_sqrt(1 - cap_z * cap_z)
    h = mi.Vector3f(
        alpha * (cap_r * cos_phi + stretched.x),
        alpha * (cap_r * sin_phi + stretched.y),
        cap_z + stretched.z,
    )
    wo = (2 * dr.dot(wi, h) / dr.maximum(dr.squared_norm(h), 1e-30)) * h - wi
    return mi.Vector3f(wo.x, wo.y, dr.abs(wo.z))
