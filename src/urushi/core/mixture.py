"""Proposals: mixtures of GGX reflection lobes and a cosine lobe, from which directions are drawn.

Directions below the horizon are mirrored up, so that the density is exactly normalised over the
upper hemisphere.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import drjit as dr

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.frame import square_to_cosine_hemisphere


class Mixture(NamedTuple):
    """The proposal for one wi.

    Attributes:
        weights: K + 1 numbers of sum 1, the last the cosine lobe's.
        alphas: the K GGX widths, all of them single numbers or all of them `Widths`.
    """

    weights: Sequence[Any]
    alphas: Sequence[Any]

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""
        density = self.weights[-1] * (wo.z * dr.inv_pi)
        for weight, alpha in zip(self.weights[:-1], self.alphas, strict=True):
            density += weight * reflection_pdf(alpha, wi, wo)
        return dr.select((wi.z > 0) & (wo.z > 0), density, 0)

    def sample(self, wi, choice, u):
        """Draw wo above the horizon by uniform numbers: `choice` for the lobe, two `u` for wo."""
        edge, alpha = self.weights[0], self.alphas[0]
        for weight, next_alpha in zip(self.weights[1:-1], self.alphas[1:], strict=True):
            alpha = dr.select(choice >= edge, next_alpha, alpha)
            edge = edge + weight
        cosine = square_to_cosine_hemisphere(type(wi), u[0], u[1])
        return dr.select(choice >= edge, cosine, sample_reflection(alpha, wi, u[0], u[1]))


def reflection_pdf(alpha, wi, wo):
    """Density of `sample_reflection` at wo above the horizon [1/sr], the mirrored part included.

    D(h) / (2 (cos_i + root)) with Smith's shadowing in the root, see `nets.sampler.reflection_pdf`.
    """
    alpha2 = microfacet.product(alpha)
    squeezed = microfacet.squeezed_sine2(wi + wo, alpha)
    x, y = wi.x + wo.x, wi.y + wo.y
    level = x * x + y * y  # the same for wo's mirror image
    up, down = wi.z + wo.z, wi.z - wo.z
    total = _scaled_ggx(alpha2, level, squeezed, up)
    total += dr.select(down > 0, _scaled_ggx(alpha2, level, squeezed, down), 0)
    root2 = alpha2 + (1 - alpha2) * (wi.z * wi.z)
    if isinstance(alpha, Widths):  # (u wi.x)^2 + (v wi.y)^2 + wi.z^2, and no change if u = v
        u, v = alpha.u, alpha.v
        root2 += (u - v) * (u * (wi.x * wi.x) - v * (wi.y * wi.y))
    root = dr.sqrt(root2)
    return total * (alpha2 * (0.5 * dr.inv_pi)) / (wi.z + root)


def sample_reflection(alpha, wi, u1, u2):
    """Reflect wi about a visible GGX normal and mirror it up; density `reflection_pdf`."""
    w = microfacet.stretched(wi, alpha)
    h = microfacet.cap_normal(w, alpha, (1 - u2) * (1 + w.z) - w.z, u1)
    wo = (2 * dr.dot(wi, h) / dr.maximum(dr.squared_norm(h), 1e-30)) * h - wi
    return type(wi)(wo.x, wo.y, dr.abs(wo.z))


def _scaled_ggx(alpha2, level, squeezed, z):
    """pi D(h) / alpha2 of a half vector with h_z = z and |h_xy|^2 = level.

    alpha2 is `microfacet.product`, and `squeezed` the squared sine of D (`squeezed_sine2`).
    """
    ratio = (level + z * z) / dr.maximum(squeezed + alpha2 * (z * z), 1e-30)
    return ratio * ratio
