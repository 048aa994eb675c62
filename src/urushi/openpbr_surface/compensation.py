"""Compensation of the energy that a coated base of OpenPBR loses: the white furnace reflects one.

The model loses energy because facets of a rough coat scatter once, and because codes have errors
over bright bases. The loss is measured on the white twin: the same material with all colours set to
one. It is read from tables (`interface_loss`) or computed when the material is loaded (`Furnace`),
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
from urushi.material import adding, energy
from urushi.material.albedo_rule import AZIMUTHS, albedo_rule
from urushi.mitsuba.interface_albedo import InterfaceLoss, LossVertex
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.offers import offer_of, tabulated
from urushi.mitsuba.reading.parameters import opaque
from urushi.openpbr_surface import encoding, formulas
from urushi.openpbr_surface.film import NAMES as film_parameters
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.lookups import MirrorAlbedo
from urushi.openpbr_surface.loss_table import (
    AXES,
    COSINES,
    LossAxes,
    along,
    sampled_losses,
    table_of,
    texture,
)
from urushi.openpbr_surface.model import NAMES

#: A function from parameters to the coated base without compensation.
Coated = Callable[[Inputs], "mi.BSDF"]

#: Exponent of the base's albedo in the weight of the codes' deviation over a white base.
WHITENESS = 4

#: Samples of a walk for each cosine.
SAMPLES = 1 << 14

#: Least cosine at which the albedo of a table is measured.
LEAST_COSINE = 0.02

#: Parameters that the white twin takes from the material.
_SHARED = AXES

#: The parameters of the coat.
_OF_COATS = ("coat_color", "coat_roughness", "coat_roughness_anisotropy")


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

        encoded: whether the coat has codes. coated: makes the twins.
        """
        self._inputs = inputs
        self._only_metal = inputs.is_constant("base_metalness", 1)
        self._only_dielectric = inputs.is_constant("base_metalness", 0)
        self._tinted = not inputs.is_constant("coat_color", 1)
        self._loss = interface_loss(inputs)
        self._mirror = MirrorAlbedo()
        self._dielectric = self._metal = None
        if encoded and not self._only_metal:
            self._dielectric = Furnace(inputs, 0.0, coated)
        # Codes of mixtures include multiple scattering between facets; codes of metals do not.
        if self._only_metal or not (encoded or self._only_dielectric):
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
        if not (self._only_metal and self._metal):
            loss = self._loss.seen(interface_at(self._loss, inputs, si, active), si.wi)
        tint, below, metal_below = [], (), ()
        if self._tinted:
            tint = [-optical_depth(inputs.color("coat_color", si, active), DRJIT)]
        if not self._only_metal:
            below = formulas.promised(color, internal)
        if not self._only_dielectric:
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
        coat = self._loss.lobe(vertex.loss, wo) if vertex.loss else None
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
        names = _SHARED if metalness else (*_SHARED, "specular_weight")  # it changes the index
        self._axes = axes = LossAxes(inputs, names, ("coat", "specular"))
        self._shared = _values(inputs, [name for name in names if name not in axes.varying])
        # A constant material may be evaluated by a table, a texture by codes; and so its twin. Only
        # codes of constant metals contain multiple scattering, see `encoding.MULTIPLE_FROM`.
        self._constant = self._is_constant()
        twin: dict[str, Any] = {**self._shared, "base_color": (1.0, 1.0, 1.0)}
        twin |= {"base_metalness": metalness, "coat_weight": 1.0}
        if "coat_ior" in twin:
            twin["coat_ior"] = float(formulas.interface_index(twin["coat_ior"]))
        twin |= axes.textures
        if not self._constant and metalness and inputs.is_uniform(encoding.OF_METALS):
            if isinstance(rough := twin["coat_roughness"], float):
                twin["coat_roughness"] = _hardly_varying(rough)
        elif not self._constant:
            twin["base_color"] = _hardly_varying(1.0)
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
        """Whether the parameters that the twin shares are still the same, and as constant."""
        same = _values(self._inputs, list(self._shared)) == self._shared
        return same and self._is_constant() == self._constant

    def _is_constant(self) -> bool:
        film = () if self._inputs.is_constant("thin_film_weight", 0) else film_parameters
        return self._inputs.is_uniform((*NAMES, *_OF_COATS, *film))

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


def _hardly_varying(value: float) -> dict[str, Any]:
    """A texture about a value. One of a single value would be a constant, and its coat a table."""
    return texture(np.array([[[value], [value + 1e-6]]]))


def _losses(coat: "mi.BSDF", uv: np.ndarray, cos2: np.ndarray) -> np.ndarray:
    """Losses (N, COSINES) at points of uv (N, 2) and squared cosines of azimuths (N,): of a random
    walk, of a table, or of codes by the rule of `urushi.material.energy`."""
    offer = offer_of(coat)
    if offer.latents is None:
        return sampled_losses(coat, uv, cos2, samples=SAMPLES)
    nodes = np.linspace(0, 1, COSINES) ** 2
    material = tabulated(offer.latents)
    if material is not None:
        albedos = adding.albedos(material.f, np.maximum(nodes, LEAST_COSINE))[:, 0]
        return np.tile(1 - albedos, (len(uv), 1))
    codes = np.ascontiguousarray(offer.latents.at(uv)[:, 0])
    widths = offer.latents.model.widths
    found = energy.directional_albedos(offer.latents.model, codes)
    found = found.reshape(len(uv), 1 if widths == 1 else len(AZIMUTHS), -1)
    cosines = albedo_rule(widths).cosines[: found.shape[-1]]
    # At the rule's azimuths, which are linear in the angle.
    rows = [[np.interp(nodes, cosines[::-1], row[::-1]) for row in turns] for turns in found]
    turned = np.stack(rows, axis=1)  # (azimuths, N, COSINES)
    if widths == 1:
        return 1 - turned[0]
    place = np.arccos(np.sqrt(cos2)) / (np.pi / 2) * (len(turned) - 1)
    low = np.minimum(place.astype(int), len(turned) - 2)
    share, each = (place - low)[:, None], np.arange(len(uv))
    return 1 - (1 - share) * turned[low, each] - share * turned[low + 1, each]


def _interface_losses(inputs: Inputs, uv: np.ndarray, cos2: np.ndarray) -> np.ndarray:
    """The losses of the coat's interface, as `_losses`."""
    cosine = np.tile(np.linspace(0, 1, COSINES) ** 2, len(uv))
    sine, cos2 = np.sqrt(1 - cosine**2), np.repeat(cos2, COSINES)
    wi = np.stack([sine * np.sqrt(cos2), sine * np.sqrt(1 - cos2), cosine], -1)
    si = probing.interaction(wi, np.repeat(uv, COSINES, 0))
    loss = interface_loss(inputs)
    lost = loss.lost(interface_at(loss, inputs, si, mi.Bool(True)), si.wi).numpy()
    return np.broadcast_to(lost, len(cosine)).reshape(len(uv), COSINES)
