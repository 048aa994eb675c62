"""Look-up of packed latent textures (`textures.packing`) in Dr.Jit.

f is filtered, not the code: f of the code halfway between two codes is far from the mean of both f
where the two differ much. A look-up returns the code of one texel, drawn in proportion to its
weight in the filter (Pharr, Wronski, Salvi and Fajardo 2024, *Filtering After Shading With
Stochastic Texture Filtering*) by a hash of the position and of wi. f, density and sample of a
vertex therefore belong to one texel, and f is right in the mean over positions.
"""

from collections.abc import Sequence
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.mitsuba.recording import owned
from urushi.textures.principal import PrincipalTexture
from urushi.textures.store import IDENTITY, TexelGrid, TextureStore

#: Number of steps of a texel's weight along an axis. A point within half a step of the centre of a
#: texel has this texel alone.
WEIGHT_STEPS = 256


class LatentTexture:
    """Codes at points of uv by bilinear filtering of f."""

    # For frozen functions
    DRJIT_STRUCT: ClassVar = {"_words": object} | dict.fromkeys(
        ("_size", "_affine", "_lowest", "_steps"), list
    )

    def __init__(self, store: TextureStore | PrincipalTexture, grid: TexelGrid):
        """grid: the place of the texels."""
        self._layout, self._grid, packed = store.layout, grid, store.packed
        self._words = owned(mi.UInt32, packed.bytes.reshape(-1).view(np.uint32))
        if dr.backend_v(mi.Float) == dr.JitBackend.LLVM:  # the store shares Dr.Jit's memory
            own = self._words.numpy().view(np.uint8).reshape(packed.bytes.shape)
            store.packed = packed._replace(bytes=own)
        self._size = [mi.Int32(grid.width), mi.Int32(grid.height)]
        affine = [] if grid.to_texture == IDENTITY else np.ravel(grid.to_texture).tolist()
        self._affine = [*map(mi.Float, affine)]  # a new length: frozen functions record again
        self._lowest = [mi.Float(float(value)) for value in packed.lowest]
        self._steps = [mi.Float(float(value)) for value in packed.step]
        # Read from memory, so that all textures of a model share compiled code.
        dr.make_opaque(self._size, self._affine, self._lowest, self._steps)

    def look_up(self, uv, wi) -> list[list]:
        """Codes at uv (Point2f) seen from wi: of each channel a list (size) of Dr.Jit floats."""
        return self._codes(self._gather(self._texel(uv, wi)))

    def texels(self, uv: np.ndarray) -> np.ndarray:
        """Indices (M,) of the texels at points uv (M, 2), seen from above."""
        point, normal = mi.Point2f(np.ascontiguousarray(uv.T, np.float32)), mi.Vector3f(0, 0, 1)
        return self._texel(point, normal).numpy()

    def _texel(self, uv, wi):
        """Index of the texel at uv seen from wi."""
        point = self._to_texture(uv.x, uv.y)
        return drawn_texel(point, self._size, self._grid, texel_draw(uv, wi))

    def _to_texture(self, x, y) -> tuple:
        if not self._affine:
            return x, y
        a, b, c, d, e, f = self._affine
        return dr.fma(a, x, dr.fma(b, y, c)), dr.fma(d, x, dr.fma(e, y, f))

    @property
    def _used(self) -> int:
        """Words of a texel that hold numbers; the others are padding."""
        return -(-self._layout.used_bytes // 4)

    def _gather(self, texel) -> list:
        """The words of texels."""
        words = self._layout.texel_bytes // 4
        if words == 1:
            return [dr.gather(mi.UInt32, self._words, texel)][: self._used]
        shape = words, dr.width(texel)
        return list(dr.gather(mi.ArrayXu, self._words, texel, shape=shape))[: self._used]

    def _codes(self, words: list) -> list[list]:
        """The codes that the words of texels hold."""
        layout = self._layout
        value_at: dict[tuple[int, int], Any] = {}
        codes = []
        for channel in range(layout.channels):
            code = []
            for number, (high, low) in enumerate(zip(layout.high, layout.low, strict=True)):
                start = layout.start(channel, number)
                place = start + high, start + low if low >= 0 else -1
                value = self._lowest[number] if high < 0 else value_at.get(place)
                if value is None:
                    levels = _number(words, *place)
                    value = dr.fma(levels, self._steps[number], self._lowest[number])
                    value_at[place] = value
                code.append(value)
            codes.append(code)
        return codes


def _number(words: list, high: int, low: int):
    """The number whose bytes are at these places of a texel's words; low: -1 if it has one byte."""

    def byte(place: int):
        return (words[place // 4] >> (8 * (place % 4))) & 255

    return mi.Float(byte(high) if low < 0 else (byte(high) << 8) + byte(low))


def texel_draw(uv, wi) -> list:
    """Three numbers in (0, 1) that draw a texel at uv seen from wi: along x, along y, and a level.

    They are a hash of uv and wi, multiples of 1 / `WEIGHT_STEPS` plus half of it.
    """
    bits = [_bits(value) for value in (uv.x, uv.y, wi.x, wi.y)]
    hashed, _ = mi.sample_tea_32(bits[0] + 0x9E3779B9 * bits[2], bits[1] + 0x85EBCA6B * bits[3])
    return [
        (mi.Float((hashed >> shift) % WEIGHT_STEPS) + 0.5) / WEIGHT_STEPS for shift in (8, 16, 24)
    ]


def _bits(value):
    """The bits of a float in single precision."""
    single = dr.float32_array_t(type(value))(dr.detach(value))
    return dr.reinterpret_array(mi.UInt32, single)


def drawn_texel(point: Sequence, sizes: Sequence, grid: TexelGrid, draw: Sequence):
    """Index of one of the texels around a point of texture space, row by row, drawn by its weight.

    point: x and y. sizes: Int32, numbers of texels along them. draw: of `texel_draw`.
    """
    column, row = (
        _drawn_along(x, count, grid, u) for x, count, u in zip(point, sizes, draw, strict=False)
    )
    return mi.UInt32(row * sizes[0] + column)


def _drawn_along(x, count, grid: TexelGrid, u):
    """The texel (Int32) of `drawn_texel` along one axis."""
    if grid.wrap == "repeat":
        x = x - dr.floor(x)
    elif grid.wrap == "mirror":
        x = dr.abs(x - 2 * dr.round(0.5 * x))
    else:
        x = dr.clip(x, 0, 1)
    texel = mi.Int32(dr.floor(x * count - (0.0 if grid.nearest else 0.5 - u)))
    if grid.wrap == "repeat":
        texel = dr.select(texel >= count, 0, dr.select(texel < 0, count - 1, texel))
    return dr.clip(texel, 0, count - 1)  # NaN too
