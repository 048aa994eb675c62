"""Compensation of the energy that coats and slabs of OpenPBR lose: the white furnace reflects one.

A walk, a table or a code follows light that each facet scatters once, and codes have errors over
bright bases. `LostLight` measures what is lost, on white twins over the parameters of the material:
the same material with all colours set to one, so that what it does not return is lost.
`Compensation` gives it back to a coated base as a lobe.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import anisotropic_albedos, fresnel
from urushi.core.appearance import optical_depth
from urushi.core.facets import MIRROR, multiple_albedo
from urushi.core.namespace import DRJIT
from urushi.core.quadrature import directional_albedos
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.rows import along_u, texels
from urushi.mitsuba.tables import InterfaceAlbedo, Interpolated
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs
from urushi.textures.axes import INDEX, LINEAR, Axis

#: Parameters that are axes of the table where they vary, the most important first. Codes have no
#: wider quotients of widths than those of an anisotropy of 0.89.
AXES = {
    name: Axis(name, scale, *ends)
    for name, scale, *ends in (
        ("specular_roughness", LINEAR, 0, 1),
        ("coat_roughness", LINEAR, 0, 1),
        ("coat_ior", INDEX, 1, 3),
        ("specular_roughness_anisotropy", LINEAR, 0, 0.89),
        ("coat_roughness_anisotropy", LINEAR, 0, 0.89),
        ("specular_ior", INDEX, 1, 3),
        ("base_diffuse_roughness", LINEAR, 0, 1),
    )
}

#: Nodes of each axis by the number of axes, and of codes of one width, which are cheap. Parameters
#: beyond them count as in the middle of uv.
NODES, FINE_NODES = (1, 9, 9, 5), (1, 33, 17, 9)

#: Nodes of the azimuth of materials of two widths, and of the cosine, in its root.
TURNS, COSINES = 5, 17

#: Least cosine at which light is measured.
LEAST_COSINE = 0.02

#: Samples of walks and slabs for each cosine: at a single node, and at the least at each of many,
#: which together have `MANY` times as many.
SAMPLES, LEAST_SAMPLES, MANY = 1 << 16, 1 << 12, 3

#: Azimuths of the quadrature, over a quarter turn; half of them where the azimuth matters.
AZIMUTHS = 16

#: The parameter that scales the reflectance of a dielectric, and thereby its index.
SCALE = "specular_weight"

#: A function from parameters to the coated base without compensation.
Coated = Callable[[Inputs], "mi.BSDF"]


class Place(NamedTuple):
    """Where the light is looked up, besides the direction."""

    widths: Any  # the two widths to which the azimuth is relative; () if there are none
    at: list  # coordinates of the parameters, the last axis first


class LostLight:
    """Share of the light from each direction that a white twin loses, as a table.

    Negative where the twin returns too much. Its axes are the direction, and the parameters that
    vary over the surface.
    """

    def __init__(
        self,
        inputs: Inputs,
        names: Iterable[str],
        layers: Sequence[str],
        twin: Callable[[dict[str, "mi.Texture"]], "mi.BSDF"],
        *,
        encoded: bool = False,
    ):
        """Measure the twin.

        names: of `AXES`, on which the loss depends. layers: "coat" or "specular", whose widths may
        be two. twin: makes the white twin; takes textures of the parameters that vary, by name.
        encoded: whether it has codes or a table.
        """
        self._inputs = inputs
        #: The parameters that are axes, the most important first.
        # A roughness that was changed is an axis: the table stays when it changes again.
        self.varying = [
            name
            for name in names
            if not inputs.is_uniform(name)
            or (name.endswith("roughness") and inputs.known(name) is None)
        ][: len(NODES) - 1]
        self._turning = next(
            (x for x in layers if not inputs.is_constant(f"{x}_roughness_anisotropy", 0)), None
        )
        nodes = FINE_NODES if encoded and not self._turning else NODES
        self._nodes = [nodes[len(self.varying)]] * len(self.varying)
        grid = np.meshgrid(*[np.linspace(0, 1, n) for n in self._nodes], indexing="ij")
        values = {
            name: AXES[name].values(x.ravel()) for name, x in zip(self.varying, grid, strict=True)
        }
        count = int(np.prod(self._nodes))
        cos2, weights = np.full((count, 1), 0.5), np.ones((count, 1))  # of azimuths
        if self._turning:
            pair = f"{self._turning}_roughness", f"{self._turning}_roughness_anisotropy"
            rough, bias = (values.get(n, np.full(count, inputs.middle(n))) for n in pair)
            u, v = formulas.lobe_widths(rough, bias)
            cos2 = anisotropic_albedos.cos2_at(np.linspace(0, 1, TURNS), u / v)
            weights = anisotropic_albedos.turn_weights(TURNS, u / v)
        with dr.suspend_grad():
            bsdf = twin({name: texels(x) for name, x in values.items()})
            seen = (1, -1) if _transmits(bsdf) else (1,)
            sides = [_measured(bsdf, cos2, side) for side in seen]
        hemisphere = 4 * np.linspace(0, 1, COSINES) ** 3 / (COSINES - 1)  # of 2 cos dcos
        hemisphere[-1] /= 2
        means = [
            ((part @ hemisphere) * weights).sum(1)
            for lost in sides
            for part in (lost, np.maximum(lost, 0))
        ]
        turns = [TURNS] if self._turning else []
        self._table = _table(sides, [*self._nodes, *turns, COSINES])
        self._means = _table(means, self._nodes)

    def at(self, si, active) -> Place:
        """The material at a surface interaction."""
        at, turning = self._inputs.at(si, active), self._turning
        places = [AXES[name].coordinate(getattr(at, name), DRJIT) for name in self.varying]
        return Place(at.widths(turning) if turning else (), places[::-1])

    def lost(self, w, place: Place) -> Any:
        """Share of the light from a direction w that is lost."""
        along = [DRJIT.safe_sqrt(DRJIT.absolute(w.z))]
        if self._turning:
            along.append(anisotropic_albedos.coordinates(w, place.widths, DRJIT)[0])
        sides = self._table([*along, *place.at])
        return sides[0] if len(sides) == 1 else dr.select(w.z > 0, *sides)

    def means(self, place: Place) -> list:
        """Cosine-weighted means of the share on each side, and of its positive part."""
        return self._means(place.at)


def _table(parts: Sequence[np.ndarray], shape: Sequence[int]) -> Interpolated:
    """Tables of a shape as the channels of one."""
    return Interpolated(np.stack([x.reshape(shape) for x in parts], axis=-1).astype(np.float32))


def _measured(bsdf: "mi.BSDF", cos2: np.ndarray, side: int) -> np.ndarray:
    """Losses (N, TURNS, COSINES) at N nodes along u, and squared cosines (N, TURNS) of azimuths.

    side: 1 of light from above, -1 from below. What has codes is integrated. Walks and slabs, whose
    light also goes through, are sampled: their error is up to 1 %.
    """
    cosine = np.maximum(np.linspace(0, 1, COSINES) ** 2, LEAST_COSINE)
    sine = np.sqrt(1 - cosine**2)
    integrates = probing.known_surface(bsdf).latents is not None and not _transmits(bsdf)
    samples = SAMPLES if cos2.size == 1 else max(MANY * SAMPLES // cos2.size, LEAST_SAMPLES)
    kept = np.empty((*cos2.shape, COSINES))
    for node, turn in np.ndindex(cos2.shape):
        share, uv = cos2[node, turn], along_u(len(cos2))[node : node + 1]
        x, y = sine * np.sqrt(share), sine * np.sqrt(1 - share)
        wi = np.stack([x, y, side * cosine], -1)
        if integrates:
            kept[node, turn] = _integrated(bsdf, uv, wi, anisotropic=cos2.shape[1] > 1)
        else:
            kept[node, turn] = _sampled(bsdf, uv, wi, samples)
    return 1 - kept


def _transmits(bsdf: "mi.BSDF") -> bool:
    return mi.has_flag(bsdf.flags(), mi.BSDFFlags.Transmission)


def _integrated(bsdf: "mi.BSDF", uv: np.ndarray, wi: np.ndarray, anisotropic: bool) -> np.ndarray:
    """Albedos (N,) of the first channel at uv (1, 2), for light from wi (N, 3)."""

    def f(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return probing.bsdf_values(bsdf, a, b, np.repeat(uv, len(a), axis=0))

    azimuths = AZIMUTHS // 2 if anisotropic else AZIMUTHS
    return directional_albedos(f, wi, anisotropic=anisotropic, azimuths=azimuths)[:, 0]


def _sampled(bsdf: "mi.BSDF", uv: np.ndarray, wi: np.ndarray, samples: int) -> np.ndarray:
    """As `_integrated`, by samples of each direction, which may be on either side."""
    index = np.arange(samples * len(wi))
    si = probing.interaction(np.repeat(wi, samples, 0), np.repeat(uv, len(index), 0), index * 1.0)
    u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
    context = mi.BSDFContext(mi.TransportMode.Importance)  # shares of power
    _, weight = bsdf.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
    return np.broadcast_to(weight[0].numpy(), len(index)).reshape(len(wi), -1).mean(axis=1)


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
