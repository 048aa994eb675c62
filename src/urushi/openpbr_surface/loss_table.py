"""Light that a material loses, measured over its parameters: axes of the table, and samples."""

from collections.abc import Callable, Sequence
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.core import albedos, anisotropic_albedos
from urushi.core.namespace import DRJIT
from urushi.mitsuba.interface_albedo import Interpolated
from urushi.mitsuba.reading import probing
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs

#: Parameters that are axes of the table where they vary, the most important first.
AXES = (
    *("specular_roughness", "coat_roughness", "coat_ior", "specular_roughness_anisotropy"),
    *("coat_roughness_anisotropy", "specular_ior", "base_diffuse_roughness"),
)

#: Nodes of each axis by the number of axes. Parameters beyond them count as in the middle of uv.
NODES = (1, 9, 9, 5)

#: Greatest anisotropy of an axis: codes have no wider quotients.
MOST_ANISOTROPY = 0.89

#: Nodes of the azimuth of materials of two widths, and of the cosine, in its root.
TURNS, COSINES = 5, 17

#: Degree of the polynomial that is fitted to losses against the noise of samples.
DEGREE = 5

#: Least number of samples for each cosine at a node, and the number at all nodes over that at one.
LEAST_SAMPLES, MANY = 1 << 11, 3


class LossAxes:
    """The parameters on which a loss depends, and the azimuth, as axes of a table."""

    def __init__(self, inputs: Inputs, names: Sequence[str], layers: Sequence[str]):
        """Choose the axes.

        names: the parameters, of `AXES`. layers: "coat" or "specular", whose widths may be two.
        """
        self._inputs = inputs
        varying = [name for name in AXES if name in names and self._varies(name)]
        self.varying = varying[: len(NODES) - 1]
        self._nodes = nodes = NODES[len(self.varying)]
        self.turning = next(
            (x for x in layers if not inputs.is_constant(f"{x}_roughness_anisotropy", 0)), None
        )
        axis = np.linspace(0, 1, nodes)
        grid = np.meshgrid(*[axis] * len(self.varying), indexing="ij")
        self.values = {
            name: _value_at(name, x.ravel()) for name, x in zip(self.varying, grid, strict=True)
        }
        self.turns = TURNS if self.turning else 1
        count = nodes ** len(self.varying)
        self.uv = np.column_stack([(np.arange(count) + 0.5) / count, np.full(count, 0.5)])
        self.cos2 = np.full((count, 1), 0.5)  # the squared cosines of azimuths
        self._weights = np.ones((count, 1))
        if self.turning:
            names = f"{self.turning}_roughness", f"{self.turning}_roughness_anisotropy"
            rough, bias = (self.values.get(n, np.full(count, inputs.middle(n))) for n in names)
            u, v = formulas.lobe_widths(rough, bias)
            self.cos2 = anisotropic_albedos.cos2_at(np.linspace(0, 1, TURNS), u / v)
            self._weights = anisotropic_albedos.turn_weights(TURNS, u / v)

    def _varies(self, name: str) -> bool:
        # A roughness that was changed is an axis, so that the table stays when it changes again.
        if name.endswith("roughness") and self._inputs.known(name) is None:
            return True
        return not self._inputs.is_uniform([name])

    @property
    def textures(self) -> dict[str, dict[str, Any]]:
        """Textures of the parameters that have the nodes' values at `uv`."""
        return {name: texture(values[None, :, None]) for name, values in self.values.items()}

    def measured(self, losses: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
        """The table (axes, TURNS if there are two widths, COSINES).

        losses: the losses (N, COSINES) at points uv (N, 2) and squared cosines of azimuths (N,).
        """
        found = losses(np.repeat(self.uv, self.turns, axis=0), self.cos2.ravel())
        turns = [TURNS] if self.turning else []
        return found.reshape(*[self._nodes] * len(self.varying), *turns, COSINES)

    def means(self, table: np.ndarray) -> np.ndarray:
        """The cosine-weighted means (axes) of a table."""
        rows = table.reshape(len(self.uv), self.turns, COSINES) @ hemisphere_weights()
        return (rows * self._weights).sum(1).reshape([self._nodes] * len(self.varying))

    def widths(self, si, active) -> Any:
        """The two widths to which the azimuth is relative; () if there are none."""
        return self._inputs.widths(self.turning, si, active) if self.turning else ()

    def at(self, si, active) -> list:
        """Coordinates of the parameters at a surface interaction, the last axis first."""
        return [
            _coordinate(name, self._inputs.number(name, si, active))
            for name in reversed(self.varying)
        ]


def along(w, widths: Any) -> list:
    """Coordinates of a direction on either side, the last axis first; widths: of `LossAxes`."""
    root = DRJIT.safe_sqrt(DRJIT.absolute(w.z))
    return [root, anisotropic_albedos.coordinates(w, widths, DRJIT)[0]] if widths else [root]


def _value_at(name: str, x: np.ndarray) -> np.ndarray:
    """The parameter of a coordinate in [0, 1]. Indices are from 1 to 3."""
    if not name.endswith("ior"):
        return MOST_ANISOTROPY * x if name.endswith("anisotropy") else x
    amplitude = albedos.LARGEST_AMPLITUDE * x * x
    return (1 + amplitude) / (1 - amplitude)


def _coordinate(name: str, value):
    """The inverse of `_value_at`."""
    if not name.endswith("ior"):
        return value / MOST_ANISOTROPY if name.endswith("anisotropy") else value
    amplitude = (value - 1) / (value + 1) / albedos.LARGEST_AMPLITUDE
    return DRJIT.sqrt(DRJIT.clip(amplitude, 1e-6, 1))


def hemisphere_weights() -> np.ndarray:
    """Weights (COSINES,) of a cosine-weighted mean of values at the table's nodes."""
    weight = 4 * np.linspace(0, 1, COSINES) ** 3 / (COSINES - 1)  # of 2 cos dcos
    weight[-1] /= 2
    return weight


def table_of(parts: Sequence[np.ndarray]) -> Interpolated:
    """Tables of the same axes as the channels of one."""
    return Interpolated(np.stack(parts, axis=-1).astype(np.float32))


def texture(texels: np.ndarray) -> dict[str, Any]:
    """A texture of texels (H, W, 1 or 3)."""
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(texels, np.float32)),
        "raw": True,
        "filter_type": "nearest",
        "wrap_mode": "clamp",
    }


def sampled_losses(
    bsdf: "mi.BSDF",
    uv: np.ndarray,
    cos2: np.ndarray,
    *,
    samples: int,
    below: bool = False,
    edge: bool = False,
) -> np.ndarray:
    """Losses (N, COSINES) by samples at points uv (N, 2) and squared cosines of azimuths (N,).

    samples: for each cosine, at a single point. below: whether of light from below. edge: whether
        total reflection has an edge; else a polynomial is fitted to the losses.
    """
    context = mi.BSDFContext(mi.TransportMode.Importance)  # shares of power
    roots = np.linspace(0, 1, COSINES)[1:]
    if len(uv) > 1:
        samples = max(MANY * samples // len(uv), LEAST_SAMPLES)
    index = np.arange(samples * len(roots))
    losses = np.empty((len(uv), COSINES))
    for row, (point, share) in enumerate(zip(uv, cos2, strict=True)):
        cosine = np.repeat(roots**2, samples)
        sine = np.sqrt(1 - cosine**2)
        x, y = sine * np.sqrt(share), sine * np.sqrt(1 - share)
        wi = np.stack([x, y, -cosine if below else cosine], -1)
        si = probing.interaction(wi, np.tile(point, (len(index), 1)), index * 1.0)
        u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
        _, weight = bsdf.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
        kept = np.broadcast_to(weight[0].numpy(), len(index)).reshape(len(roots), -1)
        lost = 1 - kept.mean(axis=1)
        if not edge:
            fit = np.polynomial.Polynomial.fit(roots, lost, DEGREE)
            losses[row] = fit(np.linspace(0, 1, COSINES))
        else:
            losses[row] = np.append(lost[0], lost)
    return losses
