"""Compensation of the energy that a coated base of OpenPBR loses: the white furnace reflects one.

The model loses energy because facets of a rough coat scatter once, and because networks have errors
over bright bases. The loss is that of the material's white twin: the same material with all colours
set to one. It is read from tables or computed when the material is loaded, and added as a lobe.
"""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core import metal
from urushi.openpbr import darkening, glossy, roughness
from urushi.openpbr.inputs import Inputs
from urushi.openpbr.medium import LEAST_COLOR
from urushi.openpbr.plugins.albedo import InterfaceAlbedo, MirrorAlbedo
from urushi.openpbr.plugins.furnace import Furnace

#: Power of the base's albedo by which the deviation of networks over a white base counts.
WHITENESS = 4


class LossVertex(NamedTuple):
    """A coat of `CoatLoss` at a vertex.

    Attributes:
        eta, alpha: its index and its width.
        inside: the share of light from the base that leaves, over the mean that enters.
        lost: what is lost at wi, over pi times its mean.
    """

    eta: Any
    alpha: Any
    inside: Any
    lost: Any


class Vertex(NamedTuple):
    """The material of `Compensation` at a vertex; unused entries are ().

    Attributes:
        share: base_metalness. white: how much the deviation over a white base counts.
        eta: the coat's index. f0: its reflectance at normal incidence.
        tint: one spectrum, half the logarithm of coat_color.
        path: length of the refracted path of wi.
        loss: of the coat's interface.
        below, metal_below: the colour of light that a smooth coat passes to the dielectric or
            to the metal and back, without the tint.
        dielectric, metal: the computed losses of the white twins.
    """

    share: Any
    white: Any
    eta: Any
    f0: Any
    tint: Any
    path: Any
    loss: Any
    below: Any
    metal_below: Any
    dielectric: Any
    metal: Any


class Compensation:
    """Gives back light that a coated base loses, as reciprocal lobes.

    A loss 1 - A(w) returns as (1 - A(wi)) (1 - A(wo)) / (pi (1 - A_mean)), as in Kulla and Conty
    2017, in the colour of the coated base. The interface's loss over a diffuse base is in tables.
    That over a metal, and the deviation of the networks from one over either, are measured. Over a
    dielectric the deviation is a lobe of either sign; over a metal the excess over one divides f.
    """

    def __init__(self, inputs: Inputs, encoded: bool, weights: str):
        """Measure white twins.

        encoded: whether networks layer the coat. weights: theirs, as the plugin's property.
        """
        self._inputs = inputs
        self._only_metal = inputs.is_constant("base_metalness", 1)
        self._only_dielectric = inputs.is_constant("base_metalness", 0)
        self._tinted = not inputs.is_constant("coat_color", 1)
        self._coat = CoatLoss(inputs)
        self._mirror = MirrorAlbedo()
        self._dielectric = self._metal = None
        if encoded and not self._only_metal:
            self._dielectric = Furnace(inputs, 0.0, encoded, weights, CoatLoss)
        # The codes of a mixture contain what its facets reflect more than once, a metal's do not.
        if self._only_metal or not (encoded or self._only_dielectric):
            self._metal = Furnace(inputs, 1.0, encoded, weights, None)

    @property
    def is_current(self) -> bool:
        """Whether what was measured is that of the present parameters."""
        return all(part.is_current for part in (self._dielectric, self._metal) if part)

    def vertex(self, si, active) -> "Vertex":
        """What depends on the position and on wi alone."""
        inputs = self._inputs
        share = inputs.number("base_metalness", si, active)
        color = inputs.number("base_weight", si, active) * inputs.color("base_color", si, active)
        eta = dr.clip(inputs.number("coat_ior", si, active), 1.001, 3)
        internal = glossy.internal_reflectance(1 - darkening.mean_fresnel(eta, dr), eta)
        loss: Any = ()
        if not (self._only_metal and self._metal):
            loss = self._coat.vertex(si, active)
        tint, below, metal_below = [], (), ()
        if self._tinted:
            tint = [0.5 * dr.log(dr.maximum(inputs.color("coat_color", si, active), LEAST_COLOR))]
        if not self._only_metal:
            below = glossy.promised(color, internal)
        if not self._only_dielectric:
            metal_below = glossy.promised(self._metal_color(color, si, active), internal)
        return Vertex(
            share,
            dr.power(color, WHITENESS) if self._dielectric else (),
            eta,
            dr.square((eta - 1) / (eta + 1)),
            tint,
            _path(si.wi, eta),
            loss,
            below,
            metal_below,
            self._dielectric.vertex(si, active) if self._dielectric else (),
            self._metal.vertex(si, active) if self._metal else (),
        )

    def completed(self, vertex: "Vertex", f, wo):
        """f [1/sr] of the coated base with the light that it loses."""
        share, tint = vertex.share, mi.Spectrum(1)
        for half_log in vertex.tint:  # of the refracted paths along wi and wo
            tint = dr.exp(half_log * (vertex.path + _path(wo, vertex.eta)))
        coat = self._coat.lobe(vertex.loss, wo) if vertex.loss else None
        if not self._only_metal:
            lobe = mi.Spectrum(coat)
            if self._dielectric:
                lobe += vertex.white * self._dielectric.beyond_known(vertex.dielectric, wo)
            seen = vertex.f0 + (1 - vertex.f0) * tint * vertex.below
            f = dr.maximum(f + (1 - share) * seen * lobe, 0)
        if not self._only_dielectric:
            lobe = coat
            if self._metal:
                lobe, factor = self._metal.lobe_and_factor(vertex.metal, wo)
                f = f * (factor if self._only_metal else 1 - share * (1 - factor))
            f = f + share * tint * vertex.metal_below * lobe
        return f

    def _metal_color(self, color, si, active):
        """Albedo of the metal for light that its facets reflect more than once."""
        inputs = self._inputs
        tint = inputs.color("specular_color", si, active)
        weight = dr.minimum(inputs.number("specular_weight", si, active), 1)
        mean = weight * metal.f82_mean(color, tint, dr)
        alpha = roughness.lobe_width(inputs.number("specular_roughness", si, active), dr)
        return self._mirror.multiple(mean, alpha)


def _path(w, eta):
    """Length of the refracted path along w through the coat of index eta, over its thickness."""
    return dr.rsqrt(1 - (1 - w.z * w.z) / (eta * eta))


class CoatLoss:
    """Light that the coat's interface loses over a white Lambertian base, from the tables."""

    def __init__(self, inputs: Inputs):
        self._inputs = inputs
        eta = None
        if inputs.known("coat_ior") is not None:
            eta = float(roughness.interface_index(inputs.known("coat_ior")))
        self._above = InterfaceAlbedo(eta)
        self._below = InterfaceAlbedo(None if eta is None else 1 / eta)

    def lost(self, cosine, si, active):
        """Share of the light from a direction that is lost."""
        return self._lost(self._at(si, active), cosine)

    def vertex(self, si, active) -> "LossVertex":
        """What depends on the position and on wi alone."""
        at = self._at(si, active)
        reflected, passed = self._above.both_mean(at.alpha, at.eta)
        mean = 1 - reflected - at.inside * passed
        return at._replace(lost=self._lost(at, si.wi.z) / dr.maximum(dr.pi * mean, 1e-5))

    def lobe(self, vertex: "LossVertex", wo):
        """The lobe [1/sr] of the light that is given back."""
        return vertex.lost * self._lost(vertex, wo.z)

    def _at(self, si, active) -> "LossVertex":
        """The coat at a surface interaction."""
        inputs = self._inputs
        eta = dr.clip(inputs.number("coat_ior", si, active), 1.001, 3)
        alpha = roughness.lobe_width(inputs.number("coat_roughness", si, active), dr)
        # Both from one table: what it does not reflect is passed or lost, whatever its error.
        reflected, passed = self._below.both_mean(alpha, 1 / eta)
        inside = passed / (1 - reflected)
        return LossVertex(eta, alpha, inside, ())

    def _lost(self, at: "LossVertex", cosine):
        """Share of the light from a direction that is lost."""
        reflected, passed = self._above.both(cosine, at.alpha, at.eta)
        return dr.clip(1 - reflected - at.inside * passed, 0, 1)
