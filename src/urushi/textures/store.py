"""A packed latent texture that is read and overwritten by rows, with or without a mip pyramid."""

import contextlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from urushi import parallel
from urushi.nets.weights import Model
from urushi.textures import packing
from urushi.textures.mip_pyramid import MipPyramid
from urushi.textures.packing import PackedTexels, TexelLayout

#: Texels that are packed at once: bounds memory.
PACKED_BLOCK = 1 << 17

#: Texels by slice or index.
Rows = slice | np.ndarray


class TextureStore:
    """Codes of a texture's texels, row by row; the rows of its levels follow each other.

    Attributes:
        layout, packed: layout and bytes of the texels; none before the first writing.
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
        """Whether nothing has been written yet."""
        return not len(self.packed.bytes)

    def read(self, rows: slice | np.ndarray) -> np.ndarray:
        """Codes float32 (n, channels, size) of rows."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack(self.layout, part)

    @contextlib.contextmanager
    def writing(self) -> Iterator[Callable[..., None]]:
        """A function write(rows, codes, index=None) that sets rows (n,) of the first level.

        codes: (n, channels, size); or (k, size) codes that texels share, and index (n, channels)
        chooses each texel's codes among them.

        The first writing must set all rows; they are packed together at its end. The other levels
        are computed at the end of a writing, where they change.
        """
        width, height = self.levels[0]
        coarser = self._coarser
        if self.empty and not coarser:
            written: list[tuple[Rows, np.ndarray, np.ndarray]] = []

            def collect(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
                if index is None:
                    index = np.arange(codes[..., 0].size).reshape(codes.shape[:-1])
                shared = codes.reshape(-1, codes.shape[-1]).astype(np.float16)
                written.append((rows, shared, index))

            yield collect
            self._pack_shared(written)
            return
        if self.empty and coarser:
            texels = sum(width * height for width, height in self.levels)
            whole = np.empty((texels, self.layout.channels, self.layout.size), np.float16)
            first = whole[: width * height]

            def keep(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
                first[rows] = codes if index is None else codes[index]

            yield keep
            coarser.fill(whole.__getitem__, whole.__setitem__)
            self._pack(whole)
            return
        changed = np.zeros(width * height, bool)

        def write(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
            changed[rows] = True
            self._overwrite(rows, codes if index is None else codes[index])

        yield write
        if coarser and changed.any():
            parts: list[tuple[np.ndarray, np.ndarray]] = []
            coarser.fill(
                self._read_alone, lambda *part: parts.append(part), np.flatnonzero(changed)
            )
            if parts:
                self._overwrite(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

    def _read_alone(self, rows: np.ndarray) -> np.ndarray:
        """`read` on the calling thread alone."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack_serial(self.layout, part)

    def _pack_shared(self, written: Sequence[tuple[Rows, np.ndarray, np.ndarray]]) -> None:
        """Pack every code once, and copy its bytes to the texels that share it."""
        ranges = [_value_range(codes[:, None]) for _, codes, _ in written]
        lowest, highest = (np.stack(ends) for ends in zip(*ranges, strict=True))
        width, height = self.levels[0]
        empty = np.zeros((width * height, self.layout.texel_bytes), np.uint8)
        packed = packing.with_ranges(self.layout, empty, lowest.min(axis=0), highest.max(axis=0))
        for rows, codes, index in written:
            shared = packing.pack_codes(self.layout, packed, codes)
            used = self.layout.channels * self.layout.stride
            packed.bytes[rows, :used] = shared[index].reshape(-1, used)
        self.packed = packed

    def _pack(self, whole: np.ndarray) -> None:
        lowest, highest = _value_range(whole)
        empty = np.zeros((len(whole), self.layout.texel_bytes), np.uint8)
        self.packed = packing.with_ranges(self.layout, empty, lowest, highest)
        for start in range(0, len(whole), PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, len(whole)))
            packing.pack_rows(self.layout, self.packed, rows, whole[rows])

    def _overwrite(self, rows: Rows, codes: np.ndarray) -> None:
        """Replace rows (n,) by codes (n, channels, size); a wider range repacks all texels."""
        if not packing.in_ranges(self.packed, self.layout, codes):
            self._widen(codes)
        packing.pack_rows(self.layout, self.packed, rows, codes)

    def _widen(self, codes: np.ndarray) -> None:
        narrower = self.packed
        highest = narrower.lowest + self.layout.levels * narrower.step
        wider = packing.with_ranges(
            self.layout,
            narrower.bytes,
            np.minimum(narrower.lowest, codes.min(axis=(0, 1))),
            np.maximum(highest, codes.max(axis=(0, 1))),
        )
        texels = len(narrower.bytes)
        for start in range(0, texels, PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, texels))
            packing.pack_rows(self.layout, wider, rows, self.read(rows))
        self.packed = wider


def _value_range(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest values float32 (size,) of codes (T, channels, size)."""
    pieces = [slice(start, start + PACKED_BLOCK) for start in range(0, len(whole), PACKED_BLOCK)]
    ends = np.empty((len(pieces), 2, whole.shape[-1]), np.float32)

    def find_ends(index: int) -> None:
        part = whole[pieces[index]].astype(np.float32)  # faster than in half precision
        ends[index] = part.min(axis=(0, 1)), part.max(axis=(0, 1))

    parallel.run_all_cores(find_ends, range(len(pieces)))
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
