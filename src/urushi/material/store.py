"""A packed latent texture that is read and overwritten by rows, with its mip map."""

import contextlib
from collections.abc import Callable, Iterator

import numpy as np

from urushi.material import brightness as brightnesses
from urushi.material import mipmap, packing
from urushi.material.packing import Layout, Packed
from urushi.nets.weights import Model

#: Texels that are packed anew, or averaged, at once: bounds memory.
TOGETHER = 1 << 17


class Store:
    """Codes of a texture's texels, row by row; those of its levels follow each other.

    Attributes:
        layout, packed: what it holds; nothing before it is first written.
        levels: width and height of every level.
    """

    def __init__(self, model: Model, layout: Layout, width: int, height: int, *, mipped=False):
        """mipped: whether to hold all levels, which are made when it has been written."""
        self.layout, self._model = layout, model
        self.levels = mipmap.sizes(width, height) if mipped else [(width, height)]
        nothing = np.zeros(layout.size, np.float32)
        self.packed = Packed(np.zeros((0, layout.texel_bytes), np.uint8), nothing, nothing)

    @property
    def empty(self) -> bool:
        """Whether it was never written."""
        return not len(self.packed.bytes)

    def read(self, rows: slice | np.ndarray) -> np.ndarray:
        """Codes float32 (n, channels, size) of rows."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack(self.layout, part)

    @contextlib.contextmanager
    def writing(self) -> Iterator[Callable[[np.ndarray, np.ndarray], None]]:
        """A function that writes codes (n, channels, size) to rows (n,) of the first level.

        All rows must be written the first time, which then are packed together at the end.
        """
        if self.empty:
            width, height = self.levels[0]
            whole = np.empty((width * height, self.layout.channels, self.layout.size), np.float16)
            yield whole.__setitem__
            self._pack(whole)
        else:
            yield self._overwrite
        if len(self.levels) > 1:
            self._fill_levels()

    def _pack(self, whole: np.ndarray) -> None:
        lowest, highest = whole.min(axis=(0, 1)), whole.max(axis=(0, 1))
        texels = sum(width * height for width, height in self.levels)
        empty = np.zeros((texels, self.layout.texel_bytes), np.uint8)
        self.packed = packing.within(self.layout, empty, lowest, highest)
        for start in range(0, len(whole), TOGETHER):
            rows = slice(start, min(start + TOGETHER, len(whole)))
            packing.write(self.layout, self.packed, rows, whole[rows])

    def _overwrite(self, rows: np.ndarray, codes: np.ndarray) -> None:
        """Replace rows (n,) by codes (n, channels, size); wider ranges pack all anew."""
        if not packing.fits(self.packed, self.layout, codes):
            self._widen(codes)
        packing.write(self.layout, self.packed, rows, codes)

    def _widen(self, codes: np.ndarray) -> None:
        before = self.packed
        highest = before.lowest + self.layout.levels * before.step
        wider = packing.within(
            self.layout,
            before.bytes,
            np.minimum(before.lowest, codes.min(axis=(0, 1))),
            np.maximum(highest, codes.max(axis=(0, 1))),
        )
        width, height = self.levels[0]
        for start in range(0, width * height, TOGETHER):
            rows = slice(start, min(start + TOGETHER, width * height))
            packing.write(self.layout, wider, rows, self.read(rows))
        self.packed = wider

    def _fill_levels(self) -> None:
        """Make all levels but the first, each from the one before."""
        width, height = self.levels[0]
        channels = self.layout.channels

        def read(index: np.ndarray) -> np.ndarray:
            codes = self.read(index // channels)
            return codes[np.arange(len(index)), index % channels]

        brightness = brightnesses.fitted(self._model, read, width * height * channels)
        first = 0
        for width, height in self.levels[:-1]:
            after = first + width * height
            half = max(height // 2, 1)
            together = max(TOGETHER // (4 * width), 1)
            for top in range(0, half, together):
                rows = mipmap.sources(top, min(top + together, half), height)
                codes = self.read(slice(first + rows.start * width, first + rows.stop * width))
                codes = codes.reshape(-1, width, *codes.shape[1:])
                averages = mipmap.coarser(codes, top, height, brightness)
                averages = averages.reshape(-1, *codes.shape[2:])
                start = after + top * max(width // 2, 1)
                place = slice(start, start + len(averages))
                packing.write(self.layout, self.packed, place, averages)
            first = after
