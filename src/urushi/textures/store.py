"""A packed latent texture that is read and overwritten by rows, with or without a mip pyramid."""

import contextlib
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from urushi import parallel
from urushi.nets.weights import Model
from urushi.textures import packing
from urushi.textures.mip_pyramid import fill_levels, level_sizes
from urushi.textures.packing import PackedTexels, Rows, TexelLayout

#: Texels that are packed at once: bounds memory.
PACKED_BLOCK = 1 << 17


class TextureStore:
    """Codes of a texture's texels, row by row; the rows of its levels follow each other.

    Attributes:
        layout, packed: layout and bytes of the texels; none before the first writing, which
            chooses the layout.
        levels: width and height of every level.
    """

    def __init__(
        self, model: Model, layout: TexelLayout, width: int, height: int, *, mipmaps=False
    ):
        """mipmaps: whether to hold all levels of the mip pyramid; else the first one only."""
        self.layout, self._model = layout, model
        # Channels often share numbers of their lobes, which are compared one by one.
        self._compared = model.arch.lobe
        self.levels = level_sizes(width, height) if mipmaps else [(width, height)]
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
        are computed at the end of each writing.
        """
        width, height = self.levels[0]
        coarser = len(self.levels) > 1
        if self.empty and not coarser:
            written: list[_Written] = []

            def collect(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
                ends = _value_range(codes)
                same = _same_in_channels(codes, index, self._compared)
                which = None if index is None else index.astype(np.uint32)
                written.append(
                    _Written(rows, codes.astype(np.float16, copy=False), which, ends, same)
                )

            yield collect
            self._pack_shared(written)
            return
        if self.empty:
            texels = sum(width * height for width, height in self.levels)
            whole = np.empty((texels, self.layout.channels, self.layout.size), np.float16)
            first = whole[: width * height]

            def keep(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
                first[rows] = codes if index is None else codes[index]

            yield keep
            fill_levels(self._model, width, height, whole.__getitem__, whole.__setitem__)
            self._pack(whole)
            return

        def write(rows: Rows, codes: np.ndarray, index: np.ndarray | None = None) -> None:
            self._overwrite(rows, codes if index is None else codes[index])

        yield write
        if coarser:
            parts: list[tuple[np.ndarray, np.ndarray]] = []
            fill_levels(
                self._model, width, height, self._read_alone, lambda *part: parts.append(part)
            )
            self._overwrite(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))

    def _read_alone(self, rows: np.ndarray) -> np.ndarray:
        """`read` on the calling thread alone."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack_serial(self.layout, part)

    def _pack_shared(self, written: list["_Written"]) -> None:
        """Pack every code once, and copy its bytes to the texels that share it.

        The list is emptied: each part is freed when it is packed.
        """
        lowest, highest = (np.stack(ends) for ends in zip(*(w.ends for w in written), strict=True))
        same = np.all([w.same for w in written], axis=0)
        width, height = self.levels[0]
        self._start(width * height, lowest.min(axis=0), highest.max(axis=0), same)
        while written:
            part = written.pop()
            if part.which is None:
                packing.pack_rows(self.layout, self.packed, part.rows, part.codes)
            else:
                packing.pack_shared(self.layout, self.packed, part.rows, part.codes, part.which)

    def _pack(self, whole: np.ndarray) -> None:
        lowest, highest = _value_range(whole)
        same = (whole == whole[:, :1]).all(axis=(0, 1))
        self._start(len(whole), lowest, highest, same)
        for start in range(0, len(whole), PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, len(whole)))
            packing.pack_rows(self.layout, self.packed, rows, whole[rows])

    def _start(
        self, texels: int, lowest: np.ndarray, highest: np.ndarray, same: np.ndarray
    ) -> None:
        """Choose the layout, and prepare as many texels for codes of these ranges."""
        self.layout = packing.texel_layout(
            self._model, self.layout.channels, lowest == highest, same
        )
        empty = np.zeros((texels, self.layout.texel_bytes), np.uint8)
        self.packed = packing.with_ranges(self.layout, empty, lowest, highest)

    def _overwrite(self, rows: Rows, codes: np.ndarray) -> None:
        """Replace rows (n,) by codes (n, channels, size); a wider range repacks all texels."""
        if not packing.in_ranges(self.packed, self.layout, codes):
            self._widen(codes)
        packing.pack_rows(self.layout, self.packed, rows, codes)

    def _widen(self, codes: np.ndarray) -> None:
        before, narrower = self.layout, self.packed
        highest = narrower.lowest + before.levels * narrower.step
        self._start(
            len(narrower.bytes),
            np.minimum(narrower.lowest, codes.min(axis=(0, 1))),
            np.maximum(highest, codes.max(axis=(0, 1))),
            np.array(before.same) & (codes == codes[:, :1]).all(axis=(0, 1)),
        )
        texels = len(narrower.bytes)
        for start in range(0, texels, PACKED_BLOCK):
            rows = slice(start, min(start + PACKED_BLOCK, texels))
            part = narrower._replace(bytes=narrower.bytes[rows])
            packing.pack_rows(self.layout, self.packed, rows, packing.unpack(before, part))


class _Written(NamedTuple):
    """A part of the first writing: rows, and their codes float16 (n, channels, size).

    Or codes (k, size) that texels share.

    Attributes:
        which: uint32 (n, channels), which of the codes a texel has, if they share them.
        ends: the smallest and the largest numbers (size,).
        same: (size,) whether a number is the same in all channels of each texel.
    """

    rows: Rows
    codes: np.ndarray
    which: np.ndarray | None
    ends: tuple[np.ndarray, np.ndarray]
    same: np.ndarray


def _same_in_channels(codes: np.ndarray, index: np.ndarray | None, compared: int) -> np.ndarray:
    """Whether numbers (size,) are the same in all channels; after `compared`, all or none are.

    codes: (n, channels, size), or (k, size) that are chosen by index (n, channels).
    """
    if index is None:
        same = np.full(codes.shape[-1], codes.shape[1] == 1)
        same[:compared] = _equal_channels(codes[..., :compared])
        return same
    differs = (index != index[:, :1]).any(axis=-1)
    same = np.full(codes.shape[-1], not differs.any())
    if differs.any():
        first = np.ascontiguousarray(codes[:, :compared])
        same[:compared] = _equal_channels(first[index[differs]])
    return same


def _equal_channels(codes: np.ndarray) -> np.ndarray:
    """Whether numbers (K,) of codes (n, channels, K) are the same in all channels."""
    return (codes == codes[:, :1]).all(axis=(0, 1))


def _ends(codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest numbers (size,) of codes (n, ..., size)."""
    rows = codes.reshape(len(codes), -1)  # NumPy is slow along axes as short as a code
    shape = -1, codes.shape[-1]
    least, most = rows.min(axis=0).reshape(shape), rows.max(axis=0).reshape(shape)
    return least.min(axis=0), most.max(axis=0)


def _value_range(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest values float32 (size,) of codes (T, ..., size)."""
    pieces = [slice(start, start + PACKED_BLOCK) for start in range(0, len(whole), PACKED_BLOCK)]
    ends = np.empty((len(pieces), 2, whole.shape[-1]), np.float32)

    def find_ends(index: int) -> None:
        part = whole[pieces[index]].astype(np.float32)  # faster than in half precision
        ends[index] = _ends(part)

    parallel.run_all_cores(find_ends, range(len(pieces)))
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
