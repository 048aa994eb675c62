"""Proposals: mixtures of GGX reflection lobes and a cosine lobe, from which directions are drawn.

Directions below the horizon are mirrored up, so that the density is exactly normalised over the
upper hemisphere.
"""

import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.namespace import DRJIT


class Mixture(NamedTuple):
    """The proposal for one wi."""

    weights: Sequence[Any]  # K + 1 numbers of sum 1, the last the cosine lobe's
    alphas: Sequence[Any]  # the K GGX widths, all of them single numbers or all of them `Widths`

    def pdf(self, wi, wo, xp=DRJIT):
        """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""
        density = self.weights[-1] * (wo.z * (1 / math.pi))
        for weight, alpha in zip(self.weights[:-1], self.alphas, strict=True):
            density = density + weight * reflection_pdf(alpha, wi, wo, xp)
        return xp.where((wi.z > 0) & (wo.z > 0), density, 0)

    def sample(self, wi, choice, u, xp=DRJIT):
        """Draw wo above the horizon by uniform numbers: `choice` for the lobe, two `u` for wo."""
        edge, alpha = self.weights[0], self.alphas[0]
        for weight, further in zip(self.weights[1:-1], self.alphas[1:], strict=True):
            chosen = functools.partial(xp.where, choice >= edge)
            alpha = microfacet.of_widths(chosen, further, alpha)
            edge = edge + weight
        cosine = square_to_cosine_hemisphere(type(wi), u[0], u[1], xp)
        reflected = sample_reflection(alpha, wi, u[0], u[1], xp)
        pairs = zip(cosine, reflected, strict=True)
        return type(wi)(*(xp.where(choice >= edge, a, b) for a, b in pairs))


def reflection_pdf(alpha, wi, wo, xp=DRJIT):
    """Density of `sample_reflection` at wo above the horizon [1/sr], the mirrored part included.

    A visible normal has the density G1(wi) (wi.h) D(h) / cos_i (Heitz 2018, eq. 1); its
    reflection has that density divided by 4 wi.h. With Smith's G1 = 2 cos_i / (cos_i + root) for
    GGX, the quotient is D(h) / (2 (cos_i + root)). D is computed from h = wi + wo without
    normalising it.
    """
    named = xp.named
    x, y = named("half_x", wi.x + wo.x), named("half_y", wi.y + wo.y)
    x2, y2, cos2 = x * x, y * y, wi.z * wi.z
    level = squeezed = named("half_xy2", x2 + y2)  # the same for wo's mirror image
    if isinstance(alpha, Widths):
        u, v = alpha.u, alpha.v
        alpha2, u_v, v_u = microfacet.product_and_quotients(alpha, xp)
        squeezed = named("squeezed", x2 * v_u + y2 * u_v)
    else:
        alpha2 = named("alpha2", alpha * alpha)
    root2 = alpha2 + (1.0 - alpha2) * cos2
    if isinstance(alpha, Widths):  # (u wi.x)^2 + (v wi.y)^2 + wi.z^2, and no change if u = v
        root2 = root2 + (u - v) * (u * (wi.x * wi.x) - v * (wi.y * wi.y))

    def ratio(z, label):
        """The root of pi D(h) / alpha2 of a half vector with h_z = z."""
        z2 = named(f"{label}2", z * z)
        return named(f"ratio_{label}", (level + z2) / xp.maximum(squeezed + alpha2 * z2, 1e-18))

    up, down = named("up", wi.z + wo.z), named("down", wi.z - wo.z)
    upper, lower = ratio(up, "up"), ratio(down, "down")
    total = upper * upper + xp.where(down > 0.0, lower * lower, 0.0)
    # > 0 even for wi below the horizon
    below = named("below", xp.positive(wi.z) + xp.sqrt(root2))
    return total * (alpha2 / (2.0 * math.pi)) / below


def sample_reflection(alpha, wi, u1, u2, xp=DRJIT):
    """Reflect wi about a visible GGX normal and mirror it up; density `reflection_pdf`."""
    h = microfacet.visible_normal(alpha, wi, u1, u2, xp)
    length2 = h.x * h.x + h.y * h.y + h.z * h.z
    product = 2.0 * (wi.x * h.x + wi.y * h.y + wi.z * h.z)
    scale = xp.named("twice_cosine", product / xp.maximum(length2, 1e-18))
    return type(wi)(scale * h.x - wi.x, scale * h.y - wi.y, xp.absolute(scale * h.z - wi.z))
