"""A packed latent texture that is read and overwritten by rows, with or without a mip pyramid."""

import contextlib
from collections.abc import Callable, Iterator

import numpy as np

from urushi import parallel
from urushi.nets.weights import Model
from urushi.textures import packing
from urushi.textures.mip_pyramid import MipPyramid
from urushi.textures.packing import PackedTexels, TexelLayout

#: Texels that are packed at once: bounds memory.
PACKED_BLOCK = 1 << 17


class TextureStore:
    """Codes of a texture's texels, row by row; those of its levels follow each other.

    Attributes:
        layout, packed: what it holds; nothing before it is first written.
        levels: width and height of every level.
    """

    def __init__(
        self, model: Model, layout: TexelLayout, width: int, height: int, *, mipmaps=False
    ):
        """mipmaps: whether to hold all levels of the mip pyramid; else the first one only."""
        self.layout = layout
        self._coarser = MipPyramid(model, width, height, layout.channels) if mipmaps else None
        self.levels = self._coarser.sizes if self._coarser else [(width, height)]
        nothing = np.zeros(layout.size, np.float32)
        self.packed = PackedTexels(np.zeros((0, layout.texel_bytes), np.uint8), nothing, nothing)

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

        All rows must be written the first time, which then are packed together at the end. The
        other levels are made, or made anew where that is needed, at the end.
        """
        width, height = self.levels[0]
        if self.empty:
            texels = sum(width * height for width, height in self.levels)
            whole = np.empty((texels, self.layout.channels, self.layout.size), np.float16)
            yield whole[: width * height].__setitem__
            if self._coarser:
                self._coarser.fill(whole.__getitem__, whole.__setitem__)
            self._pack(whole)
            return
        changed = np.zeros(width * height, bool)

        def write(rows: np.ndarray, codes: np.ndarray) -> None:
            changed[rows] = True
            self._overwrite(rows, codes)

        yield write
        if self._coarser and changed.any():
            parts: list[tuple[np.ndarray, np.ndarray]] = []
            self._coarser.fill(
                self._read_alone, lambda *part: parts.append(part), np.flatnonzero(changed)
            )
            if parts:
                self._overwrite(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

    def _read_alone(self, rows: np.ndarray) -> np.ndarray:
        """`read` for threads, of which each has one core."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack_serial(self.layout, part)

    def _pack(self, whole: np.ndarray) -> None:
        lowest, highest = _value_range(whole)
        empty = np.zeros((len(whole), self.layout.texel_bytes), np.uint8)
        self.packed = packing.with_ranges(self.layout, empty, lowest, highest)
        for start in range(0, len(whole), PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, len(whole)))
            packing.pack_rows(self.layout, self.packed, rows, whole[rows])

    def _overwrite(self, rows: np.ndarray, codes: np.ndarray) -> None:
        """Replace rows (n,) by codes (n, channels, size); wider ranges pack all anew."""
        if not packing.in_ranges(self.packed, self.layout, codes):
            self._widen(codes)
        packing.pack_rows(self.layout, self.packed, rows, codes)

    def _widen(self, codes: np.ndarray) -> None:
        before = self.packed
        highest = before.lowest + self.layout.levels * before.step
        wider = packing.with_ranges(
            self.layout,
            before.bytes,
            np.minimum(before.lowest, codes.min(axis=(0, 1))),
            np.maximum(highest, codes.max(axis=(0, 1))),
        )
        texels = len(before.bytes)
        for start in range(0, texels, PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, texels))
            packing.pack_rows(self.layout, wider, rows, self.read(rows))
        self.packed = wider


def _value_range(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest values float32 (size,) of codes (T, channels, size)."""
    pieces = [slice(start, start + PACKED_BLOCK) for start in range(0, len(whole), PACKED_BLOCK)]
    ends = np.empty((len(pieces), 2, whole.shape[-1]), np.float32)

    def look(index: int) -> None:
        part = whole[pieces[index]].astype(np.float32)  # of half precision it would take longer
        ends[index] = part.min(axis=(0, 1)), part.max(axis=(0, 1))

    parallel.run_all_cores(look, range(len(pieces)))
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
