"""Look-up of packed latent textures (`textures.packing`) in Dr.Jit, with mip levels.

A texel is gathered as words of four bytes. Bytes are interpolated two at a time in the halves of a
word, by integer weights that add up to 256, so that nothing overflows. Graphics hardware resolves
the position between texels equally finely. Compared with a texture of half floats, a look-up reads
two thirds of the memory or less and takes half the time.
"""

from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.render.recording import signature
from urushi.textures.grid import IDENTITY, TexelGrid
from urushi.textures.packing import TexelLayout
from urushi.textures.store import TextureStore

#: Sum of the integer weights of the four texels around a point.
UNIT = 256


def owned(kind: type, values: np.ndarray):
    """A flattened copy of NumPy values as a Dr.Jit array of type `kind`, in Dr.Jit's own memory.

    Dr.Jit shares NumPy's memory where it can. A plugin must not hold such memory: if it does not
    start at a multiple of the vector width, frozen functions (Dr.Jit 1.5) are replayed with the
    values of their recording; and freeing it while a function is recorded ends the process.
    """
    source = kind(np.ascontiguousarray(values).reshape(-1))
    copy = dr.zeros(kind, len(source))
    dr.scatter(copy, source, dr.arange(mi.UInt32, len(source)))
    dr.eval(copy)
    return copy


class LatentTexture:
    """Codes at points of uv by bilinear filtering, trilinear where the footprint is known."""

    DRJIT_STRUCT: ClassVar = {
        "_words": object,
        "_offsets": object,
        "_widths": object,
        "_heights": object,
        "_base": list,
        "_affine": list,
        "_lowest": list,
        "_steps": list,
        "_signature": list,
    }  # for frozen functions

    def __init__(self, store: TextureStore, grid: TexelGrid):
        """grid: the place of the first level's texels."""
        self._layout, self._grid = store.layout, grid
        levels, packed = store.levels, store.packed
        self._words = owned(mi.UInt32, packed.bytes.reshape(-1).view(np.uint32))
        if dr.backend_v(mi.Float) == dr.JitBackend.LLVM:  # the store shares Dr.Jit's memory
            own = self._words.numpy().view(np.uint8).reshape(packed.bytes.shape)
            store.packed = packed._replace(bytes=own)
        widths, heights = (np.array(sizes, np.uint32) for sizes in zip(*levels, strict=True))
        texels = widths.astype(np.int64) * heights
        self._offsets, self._widths, self._heights = (
            owned(mi.UInt32, numbers.astype(np.uint32))
            for numbers in (np.cumsum(texels) - texels, widths, heights)
        )
        self._levels = len(levels)
        self._base = [
            mi.Int32(int(widths[0])),
            mi.Int32(int(heights[0])),
            mi.Float(self._levels - 1),
        ]
        affine = [] if grid.to_texture == IDENTITY else np.ravel(grid.to_texture).tolist()
        self._affine = list(
            map(mi.Float, affine)
        )  # a new length makes frozen functions record again
        self._lowest = [mi.Float(float(value)) for value in packed.lowest]
        self._steps = [mi.Float(float(value) / UNIT) for value in packed.step]
        self._signature = signature(layout_states(store.layout))
        # Read from memory, so that all textures of a model share compiled code.
        dr.make_opaque(self._base, self._affine, self._lowest, self._steps)

    def look_up(self, uv, duv_dx=None, duv_dy=None) -> list[list]:
        """Codes at uv (Point2f): of each channel a list (size) of Dr.Jit floats.

        duv_dx, duv_dy: change of uv from one pixel to the next, if known. The level with texels of
        that size is used, interpolated linearly between two levels.
        """
        point = self._to_texture(uv.x, uv.y, True)
        if duv_dx is None or self._levels == 1:
            return self._codes(self._sums(point, None))
        level = self._level(duv_dx, duv_dy)
        lower = dr.minimum(mi.UInt32(level), self._levels - 2)
        fraction = level - mi.Float(lower)
        fine, coarse = (self._sums(point, index) for index in (lower, lower + 1))
        return self._codes([dr.lerp(a, b, fraction) for a, b in zip(fine, coarse, strict=True)])

    def _to_texture(self, x, y, point: bool) -> tuple:
        if not self._affine:
            return x, y
        a, b, c, d, e, f = self._affine
        if not point:
            return dr.fma(a, x, b * y), dr.fma(d, x, e * y)
        return dr.fma(a, x, dr.fma(b, y, c)), dr.fma(d, x, dr.fma(e, y, f))

    def _level(self, duv_dx, duv_dy):
        """The level, a float, whose texels have the size of a pixel along the longer axis."""
        width, height, last = self._base
        squared = mi.Float(1)
        for change in (duv_dx, duv_dy):
            x, y = self._to_texture(change.x, change.y, False)
            squared = dr.maximum(squared, dr.square(x * width) + dr.square(y * height))
        return dr.minimum(0.5 * dr.log2(squared), last)

    def _sums(self, point: tuple, level) -> list:
        """Weighted sums of each number, as floats in steps: 0 to 255 or 65535, times `UNIT`."""
        if level is None:
            offset, (width, height) = 0, self._base[:2]
        else:
            offset, width, height = (
                dr.gather(mi.UInt32, array, level)
                for array in (self._offsets, self._widths, self._heights)
            )
            width, height = mi.Int32(width), mi.Int32(height)
        columns, right = self._neighbours(point[0], width)
        rows, down = self._neighbours(point[1], height)
        both = (right * down + UNIT // 2) >> 8
        both = dr.maximum(mi.Int32(both), mi.Int32(right + down) - UNIT)
        both = mi.UInt32(both)
        weights = [[UNIT + both - right - down, right - both], [down - both, both]]
        even, odd = [0] * self._used, [0] * self._used
        for row, line in zip(rows, weights, strict=True):
            for column, weight in zip(columns, line, strict=True):
                words = self._gather(offset + mi.UInt32(row * width + column))
                for i, word in enumerate(words):
                    even[i] += (word & 0x00FF00FF) * weight
                    odd[i] += ((word >> 8) & 0x00FF00FF) * weight
        return [self._number(even, odd, *place) for place in dict.fromkeys(self._places())]

    def _neighbours(self, x, count):
        """The two texels around x along an axis, and the integer weight of the second."""
        if self._grid.wrap == "repeat":
            x -= dr.floor(x)
        elif self._grid.wrap == "mirror":
            x = dr.abs(x - 2 * dr.round(0.5 * x))
        else:
            x = dr.clip(x, 0, 1)
        x = x * count - 0.5
        first = dr.floor(x)
        fraction = x - first
        weight = mi.UInt32(
            dr.select(fraction >= 0.5, UNIT, 0) if self._grid.nearest else UNIT * fraction + 0.5
        )
        first = mi.Int32(first)
        if self._grid.wrap == "repeat":
            first = dr.select(first < 0, count - 1, first)  # NaN too
            second = dr.select(first + 1 >= count, 0, first + 1)
        else:
            second = dr.clip(first + 1, 0, count - 1)
            first = dr.clip(first, 0, count - 1)
        return (first, second), weight

    @property
    def _used(self) -> int:
        """Words of a texel that hold numbers; the others are padding."""
        return -(-self._layout.used_bytes // 4)

    def _gather(self, texel) -> list:
        words = self._layout.texel_bytes // 4
        if words == 1:
            return [dr.gather(mi.UInt32, self._words, texel)][: self._used]
        shape = words, dr.width(texel)
        return list(dr.gather(mi.ArrayXu, self._words, texel, shape=shape))[: self._used]

    def _places(self) -> list[tuple[int, int]]:
        """High byte and low byte, or -1, of every number of every channel; constants left out."""
        layout = self._layout
        return [self._place(*which) for which in self._all() if layout.high[which[1]] >= 0]

    def _all(self) -> list[tuple[int, int]]:
        return [(c, i) for c in range(self._layout.channels) for i in range(self._layout.size)]

    def _place(self, channel: int, number: int) -> tuple[int, int]:
        start = self._layout.start(channel, number)
        low = self._layout.low[number]
        return start + self._layout.high[number], start + low if low >= 0 else -1

    def _number(self, even: list, odd: list, first: int, second: int):
        def byte(index: int):
            total = (odd if index % 2 else even)[index // 4]
            return total >> 16 if index % 4 > 1 else total & 0xFFFF

        whole = byte(first)
        if second >= 0:
            whole = (whole << 8) + byte(second)
        return mi.Float(whole)

    def _codes(self, sums: list) -> list[list]:
        layout, size = self._layout, self._layout.size
        sum_at = dict(zip(dict.fromkeys(self._places()), sums, strict=True))
        value_at: dict[tuple[int, int], Any] = {}
        values = []
        for channel, number in self._all():
            if layout.high[number] < 0:
                values.append(self._lowest[number])
                continue
            place = self._place(channel, number)
            if place not in value_at:
                value_at[place] = dr.fma(sum_at[place], self._steps[number], self._lowest[number])
            values.append(value_at[place])
        return [values[i : i + size] for i in range(0, len(values), size)]


def layout_states(layout: TexelLayout) -> list[int]:
    """How each number is looked up: not at all, or with 8 or 16 bits, for all channels or one."""
    return [
        0 if high < 0 else 1 + (low >= 0) + 2 * same
        for high, low, same in zip(layout.high, layout.low, layout.same, strict=True)
    ]


def are_constant(*vectors) -> bool:
    """Whether vectors are literals: integrators without footprints leave literal zeros."""
    return all(value.state == dr.VarState.Literal for vector in vectors for value in vector)
