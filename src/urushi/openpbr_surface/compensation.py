"""Compensation of the energy that a coated base of OpenPBR loses: the white furnace reflects one.

Facets of a rough coat scatter once, and codes have errors over bright bases. `LostLight` measures
what that takes from white twins. It comes back as a lobe.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.core import fresnel
from urushi.core.appearance import optical_depth
from urushi.core.facets import MIRROR, multiple_albedo
from urushi.core.namespace import DRJIT
from urushi.mitsuba.tables import InterfaceAlbedo
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.lost_light import AXES, LostLight

#: The parameter that scales the reflectance of a dielectric, and thereby its index.
SCALE = "specular_weight"

#: A function from parameters to the coated base without compensation.
Coated = Callable[[Inputs], "mi.BSDF"]


class Part(NamedTuple):
    """The dielectric or the metal at a vertex."""

    place: Any  # in the table of lost light
    lost: Any  # from wi
    below: Any  # colour of the light that comes back, but for the tint


class Vertex(NamedTuple):
    """The material at a vertex."""

    coated: Any  # of the coated base

    share: Any  # base_metalness
    eta: Any  # the coat's index
    tint: Any  # half the logarithm of coat_color
    path: Any  # length of the refracted path of wi
    parts: list[Part]


class Compensation:
    """Gives back light that a coated base loses, as reciprocal lobes.

    L(w) is the loss of light from w, and its mean is over cosines. Over a dielectric, which has f
    in all directions, the lobe is (L(wi) + L(wo) - mean L) / pi. L may be negative. Over a metal it
    is L(wi) L(wo) / (pi mean L), after Kulla and Conty 2017, and f is divided by the larger of both
    albedos if it is above one. A mixture has both, by their shares. The lobe has the colour of the
    coated base.
    """

    UNRECORDED: ClassVar = ("_shared",)
    _transmits = False

    def __init__(self, bsdf: "mi.BSDF", inputs: Inputs, encoded: bool, coated: Coated):
        """Measure white twins.

        bsdf: the coated base. encoded: whether the coat has codes or a table. coated: makes twins.
        """
        self._bsdf, self._inputs, self._mirror = bsdf, inputs, InterfaceAlbedo(MIRROR)
        self._losses: dict[float, LostLight] = {}  # by base_metalness of the twin
        for metalness in (0.0, 1.0):
            if not inputs.is_constant("base_metalness", 1 - metalness):
                twin = partial(self._twin, coated, metalness)
                self._losses[metalness] = LostLight(
                    inputs, AXES, ("coat", "specular"), twin, encoded=encoded
                )
        self._shared = self._fixed()

    def _twin(self, coated: Coated, metalness: float, textures: dict[str, Any]) -> "mi.BSDF":
        names = AXES if metalness else (*AXES, SCALE)
        values = {name: self._inputs.middle(name) for name in names} | textures
        if "coat_ior" not in textures:
            values["coat_ior"] = float(formulas.interface_index(values["coat_ior"]))
        white = {"base_color": (1.0, 1.0, 1.0), "base_metalness": metalness, "coat_weight": 1.0}
        return coated(Inputs.of(values | white, self._inputs.where))

    def _fixed(self) -> dict[str, float]:
        """The parameters of the twins that are no axes, in the middle of uv."""
        axes = next(iter(self._losses.values())).varying
        return {n: self._inputs.middle(n) for n in (*AXES, SCALE) if n not in axes}

    @property
    def is_current(self) -> bool:
        """Whether the measured twins belong to the present parameters."""
        return self._fixed() == self._shared

    def _vertex(self, si, active) -> Vertex:
        """The quantities that depend on the position and on wi alone."""
        at = self._inputs.at(si, active)
        color, eta = at.base_weight * at.base_color, dr.maximum(at.coat_ior, 1.001)
        internal = formulas.internal_reflectance(1 - formulas.mean_fresnel(eta), eta)
        tint, parts = -optical_depth(at.coat_color, DRJIT), []
        for metalness, loss in self._losses.items():
            albedo = color
            if metalness:  # of light that its facets reflect more than once
                f82 = fresnel.f82_mean(color, at.specular_color, DRJIT)
                alpha = formulas.lobe_width(at.specular_roughness, DRJIT)
                mean = dr.minimum(at.specular_weight, 1) * f82
                albedo = multiple_albedo(mean, self._mirror.reflected(None, alpha))
            place = loss.at(si, active)
            lost = loss.lost(si.wi, place)
            parts.append(Part(place, lost, formulas.promised(albedo, internal)))
        coated = self._bsdf._vertex(si, active)
        return Vertex(coated, at.base_metalness, eta, tint, _path(si.wi, eta), parts)

    def _proposal(self, vertex: Vertex, si, active):
        return self._bsdf._proposal(vertex.coated, si, active)

    def _f_and_pdf(self, vertex: Vertex, ctx, si, wo, active):
        """Those of the coated base, f [1/sr] with the light that it loses."""
        f, pdf = self._bsdf._f_and_pdf(vertex.coated, ctx, si, wo, active)
        # Of the refracted paths along wi and wo.
        tint, total = dr.exp(vertex.tint * (vertex.path + _path(wo, vertex.eta))), f
        for (metalness, loss), part in zip(self._losses.items(), vertex.parts, strict=True):
            one, other = part.lost, loss.lost(wo, part.place)
            mean, positive = loss.means(part.place)
            if metalness:
                lobe = dr.maximum(one, 0) * dr.maximum(other, 0)
                lobe /= dr.maximum(dr.pi * positive, 1e-5)
                excess = dr.maximum(-dr.minimum(one, other), 0)  # f / (1 + excess) has none
                total += vertex.share * (tint * part.below * lobe - f * (excess / (1 + excess)))
            else:
                f0 = dr.square((vertex.eta - 1) / (vertex.eta + 1))
                seen = f0 + (1 - f0) * tint * part.below
                total += (1 - vertex.share) * seen * (dr.inv_pi * (one + other - mean))
        return dr.maximum(total, 0), pdf

    def __str__(self) -> str:
        return str(self._bsdf)


def _path(w, eta):
    """Length of the refracted path along w through the coat of index eta, over its thickness."""
    return dr.rsqrt(1 - (1 - w.z * w.z) / (eta * eta))
