"""Textures of codes of the networks of Fan et al. 2022, in Dr.Jit.

One texel is drawn, as in `mitsuba.latents.lookup`. Mip levels are means of codes: the networks'
latent space is linear (Fan et al. 2022).
"""

from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.fan2022.architecture import LATENT
from urushi.mitsuba.latents.lookup import drawn_texel, texel_draw
from urushi.mitsuba.recording import owned
from urushi.textures.store import MIDDLE, TexelGrid

#: Steps of f from one number to e times it: values within a step are the same bottom.
STEPS = 512

#: [1/sr] Values of f below it count as it.
LEAST_F = 1e-12


class CodeTexture:
    """Codes on a grid of texels, in single precision."""

    DRJIT_STRUCT: ClassVar = {"_numbers": object, "_levels": list}  # for frozen functions

    def __init__(self, codes: np.ndarray, grid: TexelGrid = MIDDLE, mipmaps: bool = False):
        """codes: (T, C, 32) of the grid's texels, or (1, C, 32)."""
        self.codes = np.broadcast_to(codes, (grid.texels, *codes.shape[1:]))
        levels = [self.codes.reshape(grid.height, grid.width, *codes.shape[1:])]
        while mipmaps and levels[-1].shape[:2] != (1, 1):
            levels.append(half_resolution(levels[-1]))
        numbers = np.concatenate([level.reshape(-1, *codes.shape[1:]) for level in levels])
        self.grid, self._numbers = grid, owned(mi.Float, numbers)
        # Of each level the number of texels before it, and its width and height.
        sizes = np.array(
            [(h * w, w, h) for h, w, *_ in (level.shape for level in levels)], np.uint32
        )
        sizes[:, 0] = np.cumsum(sizes[:, 0]) - sizes[:, 0]
        self._levels = [owned(mi.UInt32, column) for column in sizes.T]

    def vertex(self, si) -> list[list]:
        """The codes at a surface interaction: a list (32) of Dr.Jit floats for each channel.

        They are of a level whose texels have the size of a pixel where the integrator computes
        derivatives of uv.
        """
        (a, b, c), (d, e, f) = self.grid.to_texture
        point = a * si.uv.x + b * si.uv.y + c, d * si.uv.x + e * si.uv.y + f
        draw, count = texel_draw(si.uv, si.wi), dr.width(self._levels[0])
        offset, width, height = (
            mi.UInt32(0),
            mi.UInt32(self.grid.width),
            mi.UInt32(self.grid.height),
        )
        if count > 1 and not _are_constant(si.duv_dx, si.duv_dy):
            squared = mi.Float(1)
            for change in (si.duv_dx, si.duv_dy):
                x, y = a * change.x + b * change.y, d * change.x + e * change.y
                squared = dr.maximum(squared, dr.square(x * width) + dr.square(y * height))
            level = dr.minimum(mi.UInt32(0.5 * dr.log2(squared) + draw[2]), count - 1)
            offset, width, height = (dr.gather(mi.UInt32, x, level) for x in self._levels)
        sizes, channels = (mi.Int32(width), mi.Int32(height)), self.channels
        first = (offset + drawn_texel(point, sizes, self.grid, draw)) * channels
        return [
            [dr.gather(mi.Float, self._numbers, (first + c) * LATENT + i) for i in range(LATENT)]
            for c in range(channels)
        ]

    @property
    def channels(self) -> int:
        """Number of codes of a texel, one per channel."""
        return self.codes.shape[1]


def _are_constant(*vectors) -> bool:
    """Whether vectors are literals: integrators without derivatives of uv leave literal zeros."""
    return all(value.state == dr.VarState.Literal for vector in vectors for value in vector)


def half_resolution(values: np.ndarray) -> np.ndarray:
    """Averages (h, w, ...) over areas of a level's values (H, W, ...): the next level."""
    return _half(_half(values).swapaxes(0, 1)).swapaxes(0, 1)


def _half(values: np.ndarray) -> np.ndarray:
    """Averages along the first axis: of two values, or of three by area if the count is odd."""
    count, half = len(values), len(values) // 2
    if count == 1:
        return values
    first, second = values[: 2 * half : 2], values[1 : 2 * half : 2]
    if count % 2 == 0:
        return 0.5 * (first + second)
    index = np.arange(half, dtype=np.float32).reshape(-1, *[1] * (values.ndim - 1))
    return ((half - index) * first + half * second + (index + 1) * values[2::2]) / count


def different_rows(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices (K,) of rows of f (M, P) that differ, and the place (M,) of each row among them."""
    steps = np.rint(STEPS * np.log(np.maximum(f, LEAST_F))).astype(np.int32)
    _, first, place = np.unique(steps, axis=0, return_index=True, return_inverse=True)
    return first, place.ravel()
