"""The white furnace of a coated base: one minus the directional albedo of its white twin."""

from collections.abc import Callable
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import adding, energy
from urushi.material.albedo_rule import albedo_rule
from urushi.mitsuba.latents.holders import tabulated
from urushi.mitsuba.reading import probing
from urushi.openpbr.inputs import Inputs
from urushi.openpbr.plugins import film
from urushi.openpbr.plugins.albedo import interpolated
from urushi.openpbr.plugins.base import NAMES
from urushi.openpbr.roughness import interface_index

#: The parameters that the table depends on where they are textures, and its nodes for each.
ROUGHNESSES, NODES = ("coat_roughness", "specular_roughness"), 5

#: Nodes of the table in the root of the cosine, samples for each of a walk, and the degree of the
#: polynomial that smooths the noise.
COSINES, SAMPLES, DEGREE = 17, 1 << 14, 5

#: Least cosine at which the albedo of a table is measured.
LEAST_COSINE = 0.02

#: The parameters that the twin shares; where they are textures, it has their values in the middle
#: of uv.
_SHARED = (
    *("base_diffuse_roughness", "specular_ior", "specular_roughness_anisotropy", "coat_ior"),
    *("coat_roughness_anisotropy", *ROUGHNESSES),
)
#: The parameters of the coat.
_OF_COATS = ("coat_color", "coat_roughness", "coat_roughness_anisotropy")

#: As `_SHARED`, of a dielectric base, whose index it changes.
_OF_DIELECTRICS = ("specular_weight",)


class FurnaceVertex(NamedTuple):
    """Attributes of `Furnace` at a vertex.

    Attributes:
        at: coordinates in the table besides the cosine, its last axis first.
        lost: what is lost at wi, over pi times its mean; with a known part, what is lost beyond it
            less its mean.
        excess: one and what is too much at wi; with a known part, ().
    """

    at: list
    lost: Any
    excess: Any


class Furnace:
    """Table of one minus the directional albedo of a material's white twin; may be negative.

    The white twin has base, specular and coat colours of one, and is all metal or all dielectric.
    """

    def __init__(
        self,
        inputs: Inputs,
        metalness: float,
        encoded: bool,
        weights: str,
        known: Callable[..., Any] | None,
    ):
        """Measure the twin.

        metalness: of the twin. encoded: whether networks layer the coat. weights: theirs.
        known: of the twin's parameters, the part of the loss that is none of the table; its
            method `lost` gives it at cosines.
        """
        self._inputs = inputs
        self._varying = [name for name in ROUGHNESSES if inputs.known(name) is None]
        names = _SHARED if metalness else (*_SHARED, *_OF_DIELECTRICS)
        self._shared = _values(inputs, [name for name in names if name not in self._varying])
        # A constant material may be evaluated by a table, a texture by codes; and so its twin.
        thin_film = () if inputs.is_constant("thin_film_weight", 0) else film.NAMES
        constant = inputs.is_uniform((*NAMES, *_OF_COATS, *thin_film))
        twin, uv = _twin(self._shared, metalness, encoded, weights, self._varying, constant)
        with dr.suspend_grad():
            measure = _encoded_losses if encoded else _sampled_losses
            losses = measure(twin, uv)
            if known is not None:
                losses = losses - _known_losses(known(twin.inputs), uv)
        losses = losses.reshape(*([NODES] * len(self._varying)), COSINES)
        parts = np.maximum(losses, 0), np.maximum(-losses, 0)
        self._deviations = interpolated(np.stack(parts, axis=-1).astype(np.float32))
        root = np.linspace(0, 1, COSINES)
        weight = 4 * root**3 / (COSINES - 1)  # of 2 cos dcos
        weight[-1] /= 2
        self._signed = known is not None
        given = losses if self._signed else parts[0]
        mean = (given @ weight)[..., None].astype(np.float32)
        self._mean = interpolated(mean) if self._varying else None
        self._constant_mean = float(mean.mean())

    @property
    def is_current(self) -> bool:
        """Whether the parameters that the twin shares are still the same."""
        return _values(self._inputs, list(self._shared)) == self._shared

    def vertex(self, si, active) -> "FurnaceVertex":
        """What depends on the position and on wi alone."""
        at = [self._inputs.number(name, si, active) for name in reversed(self._varying)]
        lost, excess = self._deviations([dr.safe_sqrt(si.wi.z), *at])
        mean = mi.Float(self._constant_mean) if self._mean is None else self._mean(at)[0]
        if self._signed:
            return FurnaceVertex(at, lost - excess - mean, ())
        return FurnaceVertex(at, lost / dr.maximum(dr.pi * mean, 1e-5), 1 + excess)

    def beyond_known(self, vertex: "FurnaceVertex", wo):
        """The lobe [1/sr] of what is lost beyond the known part, negative where too much returns.

        (L(wi) + L(wo) - mean L) / pi, whose integral over wo is L(wi). Small beside f, which a
        dielectric base has in all directions.
        """
        lost, excess = self._deviations([dr.safe_sqrt(wo.z), *vertex.at])
        return dr.inv_pi * (vertex.lost + lost - excess)

    def lobe_and_factor(self, vertex: "FurnaceVertex", wo) -> tuple:
        """The lobe [1/sr] of the light that is given back, and the factor on f.

        The factor is less than one where the twin reflects more than all light.
        """
        lost, excess = self._deviations([dr.safe_sqrt(wo.z), *vertex.at])
        return vertex.lost * lost, dr.rsqrt(vertex.excess * (1 + excess))


def _values(inputs: Inputs, names: list[str]) -> dict[str, float]:
    """The values of parameters in the middle of uv."""
    return {name: inputs.middle(name) for name in names}


def _twin(
    shared: dict[str, float],
    metalness: float,
    encoded: bool,
    weights: str,
    varying: list[str],
    constant: bool,
) -> tuple["mi.BSDF", np.ndarray]:
    """The white twin, and the points of uv (N, 2) of the nodes of the table, by rows.

    constant: whether its base_color is a number, not a texture.
    """
    white = {"type": "rgb", "value": [1.0] * 3} if constant else _texture(np.ones((1, 1, 3)))
    twin: dict[str, Any] = dict(shared)
    twin["coat_ior"] = float(interface_index(shared["coat_ior"]))  # one has no coat
    nodes = np.linspace(0, 1, NODES, dtype=np.float32)
    grid = np.meshgrid(*[nodes] * len(varying), indexing="ij") if varying else []
    for name, values in zip(varying, grid, strict=True):
        twin[name] = _texture(np.atleast_2d(values)[..., None])
    rows, columns = (1, 1) if not varying else np.atleast_2d(grid[0]).shape
    v, u = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns)
    uv = np.stack([u.T.ravel(), v.T.ravel()], axis=-1)
    if encoded and weights:
        twin["weights"] = weights
    twin |= {"base_color": white, "base_metalness": metalness, "coat_weight": 1.0}
    twin |= {"reference": not encoded, "energy_compensation": False}
    return mi.load_dict({"type": "openpbr", **twin}), uv


def _texture(texels: np.ndarray) -> dict[str, Any]:
    """A texture of texels (H, W, 1 or 3)."""
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(texels, np.float32)),
        "raw": True,
        "filter_type": "nearest",
        "wrap_mode": "clamp",
    }


def _encoded_losses(twin: "mi.BSDF", uv: np.ndarray) -> np.ndarray:
    """Losses (N, COSINES) of a table, or of codes by the rule of `urushi.material.energy`."""
    neural = twin.coated
    nodes = np.linspace(0, 1, COSINES) ** 2
    material = tabulated(neural.latents)
    if material is not None:
        albedos = adding.albedos(material.f, np.maximum(nodes, LEAST_COSINE))[:, 0]
        return np.tile(1 - albedos, (len(uv), 1))
    codes = np.ascontiguousarray(neural.latents.at(uv)[:, 0])
    cosines = albedo_rule(neural.model.widths).cosines
    albedos = energy.directional_albedos(neural.model, codes)
    return np.stack([1 - np.interp(nodes, cosines[::-1], row[::-1]) for row in albedos])


def _sampled_losses(twin: "mi.BSDF", uv: np.ndarray) -> np.ndarray:
    """Losses (N, COSINES) of a random walk, by its samples at an azimuth of 45 degrees."""
    roots = np.linspace(0, 1, COSINES)[1:]
    samples = max(SAMPLES // len(uv), 1 << 11)
    index = np.arange(samples * len(roots))
    losses = np.empty((len(uv), COSINES))
    for row, point in enumerate(uv):
        cosine = np.repeat(roots**2, samples)
        sine = np.sqrt((1 - cosine**2) / 2)
        si = probing.interaction(
            np.stack([sine, sine, cosine], -1), np.tile(point, (len(index), 1)), index * 1.0
        )
        u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
        _, weight = twin.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
        reflected = np.broadcast_to(weight[0].numpy(), len(index)).reshape(len(roots), -1)
        fit = np.polynomial.Polynomial.fit(roots, 1 - reflected.mean(axis=1), DEGREE)
        losses[row] = fit(np.linspace(0, 1, COSINES))
    return losses


def _known_losses(known: Any, uv: np.ndarray) -> np.ndarray:
    """The known losses (N, COSINES) at points of uv (N, 2)."""
    cosine = np.tile(np.linspace(0, 1, COSINES, dtype=np.float32) ** 2, len(uv))
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(cosine), 1)), np.repeat(uv, COSINES, 0))
    lost = known.lost(mi.Float(cosine), si, mi.Bool(True)).numpy()
    return np.broadcast_to(lost, len(cosine)).reshape(len(uv), COSINES)
