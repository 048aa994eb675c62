"""Compensation of the energy that a coated base of OpenPBR loses: the white furnace reflects one.

The model loses energy because facets of a rough coat scatter once, and because codes have errors
over bright bases. The loss is measured on the white twin: the same material with all colours set to
one. It is read from tables (`interface_loss`) or measured when the material is loaded (`Furnace`),
and added as a lobe.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import fresnel
from urushi.core.appearance import optical_depth
from urushi.core.namespace import DRJIT
from urushi.material import adding
from urushi.mitsuba.interface_albedo import InterfaceLoss, LossVertex
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.offers import offer_of, tabulated
from urushi.mitsuba.reading.parameters import opaque
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.lookups import MirrorAlbedo
from urushi.openpbr_surface.loss_table import (
    AXES,
    COSINES,
    LossAxes,
    along,
    sampled_losses,
    table_of,
)

#: A function from parameters to the coated base without compensation.
Coated = Callable[[Inputs], "mi.BSDF"]

#: Exponent of the base's albedo in the weight of the codes' deviation over a white base.
WHITENESS = 4

#: Samples of a walk or of codes for each cosine.
SAMPLES = 1 << 14

#: Least cosine at which the albedo of a table is measured.
LEAST_COSINE = 0.02


class Vertex(NamedTuple):
    """The material of `Compensation` at a vertex; unused entries are ()."""

    share: Any  # base_metalness
    white: Any  # weight of the deviation over a white base
    eta: Any  # the coat's index
    f0: Any  # its reflectance at normal incidence
    tint: Any  # one spectrum, half the logarithm of coat_color
    path: Any  # length of the refracted path of wi
    loss: Any  # of the coat's interface
    below: Any  # albedo of the dielectric as seen through a smooth coat without tint
    metal_below: Any  # and of the metal
    dielectric: Any  # `FurnaceVertex` of the white twin
    metal: Any  # and of the metallic one


class Compensation:
    """Gives back light that a coated base loses, as reciprocal lobes.

    The lobe of a directional loss 1 - A(w) is (1 - A(wi)) (1 - A(wo)) / (pi (1 - A_mean)), after
    Kulla and Conty 2017, times the colour of the coated base. The loss of the coat's interface over
    a Lambertian base is a table. The loss over a metal, and the codes' deviation from an albedo
    of one, are measured on white twins. Over a dielectric, the deviation is a lobe of either sign.
    Over a metal, f is divided by an albedo above one.
    """

    DRJIT_STRUCT: ClassVar = dict.fromkeys(("_loss", "_mirror", "_dielectric", "_metal"), object)

    def __init__(self, inputs: Inputs, encoded: bool, coated: Coated):
        """Measure white twins.

        encoded: whether the coat has codes or a table. coated: makes the twins.
        """
        self._inputs = inputs
        self._tinted, self._mirror = not inputs.is_constant("coat_color", 1), MirrorAlbedo()
        self._loss = self._dielectric = self._metal = None
        if not inputs.is_constant("base_metalness", 1):
            self._loss = interface_loss(inputs)
            self._dielectric = Furnace(inputs, 0.0, coated) if encoded else None
        if not inputs.is_constant("base_metalness", 0):
            self._metal = Furnace(inputs, 1.0, coated)

    @property
    def is_current(self) -> bool:
        """Whether the measured twins belong to the present parameters."""
        return all(part.is_current for part in (self._dielectric, self._metal) if part)

    def vertex(self, si, active) -> "Vertex":
        """The quantities that depend on the position and on wi alone."""
        inputs = self._inputs
        share = inputs.number("base_metalness", si, active)
        color = inputs.number("base_weight", si, active) * inputs.color("base_color", si, active)
        eta = dr.maximum(inputs.number("coat_ior", si, active), 1.001)
        internal = formulas.internal_reflectance(1 - formulas.mean_fresnel(eta), eta)
        loss: Any = ()
        tint, below, metal_below = [], (), ()
        if self._tinted:
            tint = [-optical_depth(inputs.color("coat_color", si, active), DRJIT)]
        if self._loss:
            loss = self._loss.seen(interface_at(self._loss, inputs, si, active), si.wi)
            below = formulas.promised(color, internal)
        if self._metal:
            weight = dr.minimum(inputs.number("specular_weight", si, active), 1)
            f82 = fresnel.f82_mean(color, inputs.color("specular_color", si, active), DRJIT)
            alpha = formulas.lobe_width(inputs.number("specular_roughness", si, active), DRJIT)
            # Of the metal, the albedo for light that its facets reflect more than once.
            metal_below = formulas.promised(self._mirror.multiple(weight * f82, alpha), internal)
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
        if self._loss:
            lobe = mi.Spectrum(self._loss.lobe(vertex.loss, wo))
            if self._dielectric:
                lobe += vertex.white * self._dielectric.beyond_known(vertex.dielectric, wo)
            seen = vertex.f0 + (1 - vertex.f0) * tint * vertex.below
            f = dr.maximum(f + (1 - share) * seen * lobe, 0)
        if self._metal:
            lobe, factor = self._metal.lobe_and_factor(vertex.metal, wo)
            f = f * (1 - share * (1 - factor)) + share * tint * vertex.metal_below * lobe
        return f


def _path(w, eta):
    """Length of the refracted path along w through the coat of index eta, over its thickness."""
    return dr.rsqrt(1 - (1 - w.z * w.z) / (eta * eta))


def interface_loss(inputs: Inputs) -> InterfaceLoss:
    """Light that the coat's interface loses over a white Lambertian base."""
    ior = inputs.known("coat_ior")
    two_widths = not inputs.is_constant("coat_roughness_anisotropy", 0)
    return InterfaceLoss(None if ior is None else float(formulas.interface_index(ior)), two_widths)


def interface_at(loss: InterfaceLoss, inputs: Inputs, si, active) -> LossVertex:
    """The coat's interface at a surface interaction."""
    eta = formulas.interface_index(inputs.number("coat_ior", si, active), DRJIT)
    return loss.at(inputs.widths("coat", si, active), eta)


class FurnaceVertex(NamedTuple):
    """`Furnace` at a vertex.

    If a part of the loss is known, losses are without it, and their mean is subtracted.
    """

    widths: Any  # to which the azimuth is relative
    at: list  # coordinates in the table besides the direction, its last axis first
    lost: Any  # the loss at wi; divided by pi and by its mean if no part is known
    excess: Any  # one plus the gain at wi; () if a part of the loss is known


class Furnace:
    """Table of one minus the directional albedo of a material's white twin; may be negative.

    The white twin has base, specular and coat colours of one, and is all metal or all dielectric.
    The table of a dielectric is without the known part of the loss, at the coat's interface.
    """

    DRJIT_STRUCT: ClassVar = dict.fromkeys(
        ("_deviations", "_mean", "_constant_mean"), object
    )  # for frozen functions
    UNRECORDED: ClassVar = ("_shared",)

    def __init__(self, inputs: Inputs, metalness: float, coated: Coated):
        """Measure the twin.

        metalness: of the twin, 0 or 1. coated: makes the twin of its parameters.
        """
        self._inputs = inputs
        names = AXES if metalness else (*AXES, "specular_weight")  # it changes the index
        self._axes = axes = LossAxes(inputs, names, ("coat", "specular"))
        self._shared = _values(inputs, [name for name in names if name not in axes.varying])
        twin: dict[str, Any] = {**self._shared, "base_color": (1.0, 1.0, 1.0)}
        twin |= {"base_metalness": metalness, "coat_weight": 1.0}
        if "coat_ior" in twin:
            twin["coat_ior"] = float(formulas.interface_index(twin["coat_ior"]))
        twin |= axes.textures
        parameters = Inputs.of(twin, inputs.where)
        with dr.suspend_grad():
            bsdf = coated(parameters)
            losses = axes.measured(partial(_losses, bsdf))
            if not metalness:
                losses -= axes.measured(partial(_interface_losses, parameters))
        parts = np.maximum(losses, 0), np.maximum(-losses, 0)
        self._deviations = table_of(parts)
        self._signed = not metalness
        mean = axes.means(losses if self._signed else parts[0])
        self._mean = table_of([mean]) if axes.varying else None
        self._constant_mean = opaque(float(mean.mean()))

    @property
    def is_current(self) -> bool:
        """Whether the parameters that the twin shares are still the same."""
        return _values(self._inputs, list(self._shared)) == self._shared

    def vertex(self, si, active) -> "FurnaceVertex":
        widths, at = self._axes.widths(si, active), self._axes.at(si, active)
        lost, excess = self._deviations([*along(si.wi, widths), *at])
        mean = self._constant_mean if self._mean is None else self._mean(at)[0]
        if self._signed:
            return FurnaceVertex(widths, at, lost - excess - mean, ())
        return FurnaceVertex(widths, at, lost / dr.maximum(dr.pi * mean, 1e-5), 1 + excess)

    def beyond_known(self, vertex: "FurnaceVertex", wo):
        """The lobe [1/sr] of the loss beyond the known part; negative where too much light returns.

        (L(wi) + L(wo) - mean L) / pi, whose integral over wo is L(wi). Small beside f, which a
        dielectric base has in all directions.
        """
        lost, excess = self._deviations([*along(wo, vertex.widths), *vertex.at])
        return dr.inv_pi * (vertex.lost + lost - excess)

    def lobe_and_factor(self, vertex: "FurnaceVertex", wo) -> tuple:
        """The compensating lobe [1/sr], and a factor on f, below one where the twin gains light."""
        lost, excess = self._deviations([*along(wo, vertex.widths), *vertex.at])
        return vertex.lost * lost, dr.rsqrt(vertex.excess * (1 + excess))


def _values(inputs: Inputs, names: list[str]) -> dict[str, float]:
    """The values of parameters in the middle of uv."""
    return {name: inputs.middle(name) for name in names}


def _losses(coat: "mi.BSDF", uv: np.ndarray, cos2: np.ndarray) -> np.ndarray:
    """Losses (N, COSINES), see `sampled_losses`; those of a table by a quadrature."""
    material = tabulated(offer_of(coat).latents)
    if material is None:
        return sampled_losses(coat, uv, cos2, samples=SAMPLES)
    cosines = np.maximum(np.linspace(0, 1, COSINES) ** 2, LEAST_COSINE)
    return np.tile(1 - adding.albedos(material.f, cosines)[:, 0], (len(uv), 1))


def _interface_losses(inputs: Inputs, uv: np.ndarray, cos2: np.ndarray) -> np.ndarray:
    """The losses of the coat's interface, as `_losses`."""
    cosine = np.tile(np.linspace(0, 1, COSINES) ** 2, len(uv))
    sine, cos2 = np.sqrt(1 - cosine**2), np.repeat(cos2, COSINES)
    wi = np.stack([sine * np.sqrt(cos2), sine * np.sqrt(1 - cos2), cosine], -1)
    si = probing.interaction(wi, np.repeat(uv, COSINES, 0))
    loss = interface_loss(inputs)
    lost = loss.lost(interface_at(loss, inputs, si, mi.Bool(True)), si.wi).numpy()
    return np.broadcast_to(lost, len(cosine)).reshape(len(uv), COSINES)
