"""Latent codes that carry gradients, as a plugin holds them: the counterparts of `latents`.

Only f depends on them in a way that is differentiated. Directions are drawn, and their densities
told, by detached codes: as in all of Mitsuba's differentiable integrators, samples stay where they
are while the integrand changes.
"""

from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.weights import Model
from urushi.render.codes.latents import ConstantLatents, Vertex, looked_up
from urushi.render.networks import twins
from urushi.render.reading.grid import Grid


class AttachedLatents(ConstantLatents):
    """One attached code per channel.

    The decoder multiplies codes with its first layer at every evaluation: its shares of them are
    four times as many numbers, each of which would gather its gradient from all evaluations.
    """

    DRJIT_STRUCT: ClassVar[dict] = ConstantLatents.DRJIT_STRUCT | {"_numbers": object}

    def __init__(self, model: Model, latents: "mi.TensorXf"):
        """latents: (C, 32) or (1, C, 32)."""
        channels, self._size = latents.shape[-2:]
        super().__init__(model, dr.detach(latents).numpy().reshape(channels, self._size))
        self.tensor = latents
        self._numbers = latents.array
        dr.make_opaque(self._numbers)

    def f(self, vertex: Vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._decoder.of_latents(self.codes(si.uv), si.wi, wo)

    def codes(self, uv: "mi.Point2f") -> list[list]:
        """Attached codes: of each channel a list (32) of Dr.Jit floats."""
        # Read here, and not once for all: what a call within a call is given must be the result of
        # an operation in the outer one, or Dr.Jit overlooks its gradient.
        numbers = [dr.gather(mi.Float, self._numbers, i) for i in range(len(self._numbers))]
        return [numbers[i : i + self._size] for i in range(0, len(numbers), self._size)]


class AttachedTexture:
    """A texture of attached codes, in single precision."""

    DRJIT_STRUCT: ClassVar = {"_texture": object}  # for frozen functions

    def __init__(self, model: Model, latents: "mi.TensorXf", grid: Grid):
        """latents: (height, width, C, 32), of the grid's texels."""
        height, width, self.channels, self._size = latents.shape
        self._decoder, self._proposal = twins.of(model)
        self.grid = grid
        self.tensor = _filled_up(latents.array, (height, width), self.channels * self._size)
        self._texture = mi.Texture2f(
            self.tensor,
            use_accel=False,
            filter_mode=dr.FilterMode.Nearest if grid.nearest else dr.FilterMode.Linear,
            wrap_mode=getattr(dr.WrapMode, grid.wrap.capitalize()),
        )

    def f(self, vertex: Vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._decoder.of_latents(self.codes(si.uv), si.wi, wo)

    def vertex(self, si, active) -> Vertex:
        """The proposal for si.wi, which carries no gradient of the codes."""
        with dr.suspend_grad():
            latents = self.codes(si.uv)
        mean = [sum(values) * (1 / self.channels) for values in zip(*latents, strict=True)]
        return Vertex([], self._proposal.of_latent(mean, si.wi.z))

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Detached codes (M, C, 32) at points uv (M, 2)."""
        with dr.suspend_grad():
            return looked_up(self.codes, uv)

    def codes(self, uv: "mi.Point2f") -> list[list]:
        """Attached codes at points uv: of each channel a list (32) of Dr.Jit floats."""
        (a, b, c), (d, e, f) = self.grid.to_texture
        point = mi.Point2f(a * uv.x + b * uv.y + c, d * uv.x + e * uv.y + f)
        values = list(self._texture.eval(point))
        starts = range(0, self.channels * self._size, self._size)
        return [values[i : i + self._size] for i in starts]

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of the texture."""
        return self.grid.width, self.grid.height

    def __str__(self) -> str:
        width, height = self.resolution
        return f"{width} x {height} texels of {self.channels} x {self._size}"


def _filled_up(values: "mi.Float", shape: tuple[int, int], size: int) -> "mi.TensorXf":
    """A tensor (*shape, K) of values, `size` for each texel, and zeros up to a power of two.

    Dr.Jit's texture would fill itself up, by values that could not be reached from outside.
    """
    whole = 1 << (size - 1).bit_length()
    index = dr.arange(mi.UInt32, shape[0] * shape[1] * whole)
    texel = index // whole
    number = index - texel * whole
    return mi.TensorXf(
        dr.gather(mi.Float, values, texel * size + number, number < size), (*shape, whole)
    )
