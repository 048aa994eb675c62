"""Compensation of the energy that a coated base of OpenPBR loses: the white furnace reflects one.

Facets of a rough coat scatter once, and networks deviate over bright bases. What a white twin of
the material does not reflect, known from tables or measured when it is loaded, is given back.
"""

import drjit as dr

from urushi.openpbr_surface import darkening, glossy, metal, roughness
from urushi.openpbr_surface.medium import LEAST_COLOR
from urushi.render.plugins.openpbr_albedo import InterfaceAlbedo, MirrorAlbedo
from urushi.render.plugins.openpbr_furnace import Furnace
from urushi.render.reading.openpbr_inputs import Inputs

#: Power of the base's albedo by which the deviation of networks over a white base counts.
WHITENESS = 4


class Compensation:
    """Gives back light that a coated base loses, as reciprocal lobes.

    A loss 1 - A(w) returns as (1 - A(wi)) (1 - A(wo)) / (pi (1 - A_mean)), as in Kulla and Conty
    2017, in the colour of the coated base. The interface's loss over a diffuse base is in tables.
    That over a metal, and the deviation of the networks from one over either, are measured; the
    networks' excess over one divides f.
    """

    def __init__(self, inputs: Inputs, encoded: bool, weights: str):
        """Measure white twins.

        encoded: whether networks layer the coat. weights: theirs, as the plugin's property.
        """
        self._inputs, self._encoded = inputs, encoded
        self._coat = CoatLoss(inputs)
        self._mirror = MirrorAlbedo()
        self._dielectric = self._metal = None
        if encoded and not inputs.is_constant("base_metalness", 1):
            self._dielectric = Furnace(inputs, 0.0, encoded, weights, CoatLoss)
        # The codes of a mixture contain what its facets reflect more than once, a metal's do not.
        if inputs.is_constant("base_metalness", 1) or not (
            encoded or inputs.is_constant("base_metalness", 0)
        ):
            self._metal = Furnace(inputs, 1.0, encoded, weights, None)

    def completed(self, f_cos, si, wo, active):
        """f cos of the coated base with the light that it loses."""
        inputs = self._inputs
        share = inputs.number("base_metalness", si, active)
        cosine = dr.maximum(wo.z, 0)
        color = inputs.number("base_weight", si, active) * inputs.color("base_color", si, active)
        if not inputs.is_constant("base_metalness", 1):
            f0, passed = self._coated_colors(color, si, wo, active)
            seen = f0 + (1 - f0) * passed
            f = seen * self._coat.lobe(si, wo, active)
            if self._dielectric:
                white = color * color
                white *= white
                f += seen * white * self._dielectric.lobe(si, wo, active)
                f_cos *= 1 - (1 - share) * white * (1 - self._dielectric.factor(si, wo, active))
            f_cos += (1 - share) * cosine * f
        if not inputs.is_constant("base_metalness", 0):
            lobe = self._metal or self._coat
            if self._metal:
                f_cos *= 1 - share * (1 - self._metal.factor(si, wo, active))
            seen = self._metal_color(color, si, wo, active)
            f_cos += share * cosine * seen * lobe.lobe(si, wo, active)
        return f_cos

    def _coated_colors(self, color, si, wo, active):
        """Of a smooth coat over a base of albedo `color`: its own reflectance at normal incidence,
        and the colour of the light that it passes to the base and back.

        The tint is that of the refracted paths along wi and wo.
        """
        eta = dr.clip(self._inputs.number("coat_ior", si, active), 1.001, 3)
        f0 = dr.square((eta - 1) / (eta + 1))
        internal = glossy.internal_reflectance(1 - darkening.mean_fresnel(eta, dr), eta)
        tint = dr.maximum(self._inputs.color("coat_color", si, active), LEAST_COLOR)
        paths = [dr.rsqrt(1 - (1 - w.z * w.z) / (eta * eta)) for w in (si.wi, wo)]
        tint = dr.power(tint, 0.5 * (paths[0] + paths[1]))
        return f0, tint * glossy.promised(color, internal)

    def _metal_color(self, color, si, wo, active):
        """Albedo of the coated metal for light that its facets reflect more than once."""
        inputs = self._inputs
        tint = inputs.color("specular_color", si, active)
        weight = dr.minimum(inputs.number("specular_weight", si, active), 1)
        mean = weight * metal.f82_mean(color, tint)
        alpha = roughness.lobe_width(inputs.number("specular_roughness", si, active), dr)
        return self._coated_colors(self._mirror.multiple(mean, alpha), si, wo, active)[1]


class CoatLoss:
    """Light that the coat's interface loses over a white Lambertian base, from the tables."""

    def __init__(self, inputs: Inputs):
        self._inputs = inputs
        eta = None
        if "coat_ior" in inputs.constants:
            eta = float(roughness.interface_index(inputs.constants["coat_ior"]))
        self._above = InterfaceAlbedo(eta)
        self._below = InterfaceAlbedo(None if eta is None else 1 / eta)

    def lost(self, cosine, si, active):
        """Share of the light from a direction that is lost."""
        return self._losses([cosine], si, active)[0]

    def lobe(self, si, wo, active):
        """The lobe [1/sr] of the light that is given back."""
        first, second, mean = self._losses([si.wi.z, wo.z], si, active)
        return first * second / dr.maximum(dr.pi * mean, 1e-5)

    def _losses(self, cosines, si, active) -> list:
        """The losses at cosines, and their mean over the hemisphere."""
        inputs = self._inputs
        eta = dr.clip(inputs.number("coat_ior", si, active), 1.001, 3)
        alpha = roughness.lobe_width(inputs.number("coat_roughness", si, active), dr)
        inside = self._above.passed_mean(alpha, eta) / (eta * eta)
        inside = inside / (1 - self._below.reflected_mean(alpha, 1 / eta))
        losses = []
        for cosine in cosines:
            reflected = self._above.reflected(cosine, alpha, eta)
            kept = reflected + inside * self._above.passed(cosine, alpha, eta)
            losses.append(dr.clip(1 - kept, 0, 1))
        mean = self._above.reflected_mean(alpha, eta)
        return [*losses, 1 - mean - inside * self._above.passed_mean(alpha, eta)]
