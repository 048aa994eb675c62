"""Baking of latent textures, without a renderer.

The inputs of every texel and channel have a hash. Rows, which are pairs of a texel and a channel,
of equal hashes are computed once, wherever they are in the texture. After a change, only texels
whose hashes have changed are computed again. The rows of a coat are its parameters and the code of
its bottom, which are layered all at once (`textures.layering`).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.random import INCREMENT, mix64
from urushi.nets.weights import Model
from urushi.textures.store import TexelGrid, TextureStore

#: Bits of the mantissa that numbers are rounded to, a relative step of 1e-4: texture filters return
#: texels with rounding errors, and half precision rounds more.
MANTISSA_BITS = 12

#: Texels whose inputs are read and compared at once: bounds memory.
TEXEL_BLOCK = 1 << 18

#: Numbers (k, size) of rows, by the indices (k,) of texels, in ascending order, and of channels.
RowsAt = Callable[[np.ndarray, np.ndarray], np.ndarray]

#: Gives the texels start to stop - 1: hashes uint64 (n or 1, C) of their inputs, and the function
#: that gives rows, whose texels are counted from start.
Source = Callable[[int, int], tuple[np.ndarray, RowsAt]]

#: Gives the coat's parameters at texels start to stop - 1, arrays (n, 1 or C).
Coats = Callable[[int, int], CoatParameters]


class BakedTexture:
    """The packed codes of a source on a grid of texels, none before the first `update`."""

    def __init__(self, model: Model, grid: TexelGrid, channels: int):
        self.grid = grid
        self._hashes = np.zeros((grid.texels, channels), np.uint64)
        self.store = TextureStore(model, channels, grid.texels)

    def update(
        self,
        source: Source,
        advance: Callable[[int], Any] = lambda texels: None,
        codes_of: Callable[[np.ndarray], np.ndarray] = lambda rows: rows,
    ) -> None:
        """Compute the texels with a changed hash.

        Args:
            source: gives the rows.
            advance: called with the number of texels of each block when it is read.
            codes_of: the codes (k, L) of all different rows that have changed.
        """
        shared = SharedRows()
        rows, index, hashes = [], [], []
        for start in range(0, self.grid.texels, TEXEL_BLOCK):
            stop = min(start + TEXEL_BLOCK, self.grid.texels)
            present, rows_at = source(start, stop)
            former = self._hashes[start:stop]
            present = np.broadcast_to(present, former.shape)
            changed = np.flatnonzero((present != former).any(axis=1))
            if len(changed):
                hashes.append(present[changed])
                index.append(shared.index(hashes[-1], changed, rows_at))
                rows.append(start + changed)
            advance(stop - start)
        if rows:
            chosen = np.concatenate(rows)
            everything = len(chosen) == self.grid.texels
            place = slice(self.grid.texels) if everything else chosen
            self.store.write(place, codes_of(shared.rows), np.concatenate(index))
            self._hashes[chosen] = np.concatenate(hashes)

    def read(self, start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        """The texture as a `Source`."""

        def codes_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            texels, place = np.unique(start + texel, return_inverse=True)
            return self.store.read(texels)[place, channel]

        return self._hashes[start:stop], codes_at


class SharedRows:
    """Different rows, each hash once."""

    def __init__(self):
        self._keys, self._numbers = np.zeros(0, np.uint64), np.zeros(0, np.uint32)
        self._parts: list[np.ndarray] = []

    def index(self, hashes: np.ndarray, texels: np.ndarray, rows_at: RowsAt) -> np.ndarray:
        """The number of the row (n, C) of each of hashes (n, C); new rows are read.

        texels: (n,) by which `rows_at` counts.
        """
        keys, first, label = np.unique(hashes.ravel(), return_index=True, return_inverse=True)
        place = np.searchsorted(self._keys, keys)
        number = np.zeros(len(keys), np.uint32)
        known = place < len(self._keys)
        known[known] = self._keys[place[known]] == keys[known]
        number[known] = self._numbers[place[known]]
        fresh = np.flatnonzero(~known)
        if len(fresh):
            fresh = fresh[np.argsort(first[fresh])]  # ascending texels
            number[fresh] = len(self._keys) + np.arange(len(fresh), dtype=np.uint32)
            place_in_hashes, channel = np.divmod(first[fresh], hashes.shape[1])
            self._parts.append(rows_at(texels[place_in_hashes], channel).astype(np.float32))
            fresh = np.sort(fresh)  # ascending keys
            self._keys = np.insert(self._keys, place[fresh], keys[fresh])
            self._numbers = np.insert(self._numbers, place[fresh], number[fresh])
        return number[label].reshape(hashes.shape)

    @property
    def rows(self) -> np.ndarray:
        """The rows float32 (k, size) that `index` refers to."""
        return np.concatenate(self._parts)


def coat_source(coats: Coats, bottom: Source) -> Source:
    """The source of coats of these parameters over a bottom: rows for `layering.layer_rows`."""

    def source(start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        parameters = coats(start, stop)
        hashes, bottom_at = bottom(start, stop)

        def rows_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            def at_rows(array: np.ndarray) -> np.ndarray:
                count, width = array.shape[:2]
                return array[texel if count > 1 else 0, channel if width > 1 else 0]

            columns = [np.broadcast_to(at_rows(x), len(texel)) for x in parameters.columns()]
            return np.column_stack([bottom_at(texel, channel), *columns]).astype(np.float32)

        return row_hashes([hashes, *parameters.columns()]), rows_at

    return source


def row_hashes(columns: Sequence[np.ndarray], bits: int = MANTISSA_BITS) -> np.ndarray:
    """Hashes uint64 (...) of rows; the columns are arrays that broadcast to (...).

    Columns are floating-point numbers, which are rounded to `bits` of mantissa, or hashes (uint64).
    Two different rows have the same hash with a probability of 2^-64.
    """
    key: np.ndarray = np.zeros((), np.uint64)
    dropped = 23 - bits
    for column in columns:
        if column.dtype != np.uint64:
            stored = np.asarray(column + np.float32(0), np.float32).view(np.uint32)  # -0 is 0
            rounded = (stored + np.uint32(1 << (dropped - 1))) >> np.uint32(dropped)
            column = rounded.astype(np.uint64)
        key = mix64((key ^ column) + INCREMENT)
    return np.ascontiguousarray(key).reshape(key.shape)


def code_hashes(codes: np.ndarray, bits: int = MANTISSA_BITS) -> np.ndarray:
    """`row_hashes` (...) of vectors (..., size)."""
    return row_hashes(list(np.moveaxis(codes, -1, 0)), bits)
