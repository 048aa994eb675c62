"""The mip pyramid of a latent texture: codes of BRDFs averaged over areas, level by level.

Levels are computed from averages in the averaging space (`textures.averaging`), not from codes of
the level below, so that errors do not accumulate. All cores share the work, tile by tile; the
averages of a tile stay in a core's cache.
"""

from collections.abc import Callable

import numpy as np

from urushi import parallel
from urushi.nets.weights import Model
from urushi.textures import averaging
from urushi.textures.averaging import LobedSpace

#: Coarser levels are made from the averages of the first level with at most this many texels; and
#: the number of texels of the first level in a tile.
KEPT_TEXELS, TILE_TEXELS = 1 << 14, 1 << 10

#: From indices (n,) of texels to their codes (n, channels, size).
ReadCodes = Callable[[np.ndarray], np.ndarray]

#: Stores codes (n, channels, size) of texels with indices (n,). Indices run through all levels.
WriteCodes = Callable[[np.ndarray, np.ndarray], None]


class MipPyramid:
    """All levels of a texture but the first.

    Attributes:
        sizes: width and height of every level, the first included.
    """

    def __init__(self, model: Model, width: int, height: int, channels: int):
        self._model, self._channels = model, channels
        self.sizes = level_sizes(width, height)
        counts = [w * h for w, h in self.sizes]
        self._first = np.cumsum([0, *counts])
        self._kept = next(level for level, count in enumerate(counts) if count <= KEPT_TEXELS)

    def fill(self, read: ReadCodes, write: WriteCodes) -> None:
        """Compute the codes of the levels.

        read: reads codes of the first level. write: stores codes of the other levels. Several
        threads call both.
        """
        width, height = self.sizes[0]
        space = averaging.averaging_space(
            self._model, self._rows(read), width * height * self._channels
        )
        columns, rows = self.sizes[self._kept]
        step = max(TILE_TEXELS >> (2 * self._kept), 1)
        lifted = space.lift(self._rows(read)(np.zeros(1, np.intp)).astype(np.float32))
        means = np.empty((rows, columns, self._channels, lifted.shape[1]), np.float32)

        def make(tile: tuple[int, int]) -> None:
            y, x = tile
            across = range(x, min(x + step, columns))
            part = self._average(space, read, write, self._kept, range(y, y + 1), across)
            means[y, x : x + step] = part

        tiles = [(y, x) for y in range(rows) for x in range(0, columns, step)]
        parallel.run_all_cores(make, tiles)
        for level in range(self._kept + 1, len(self.sizes)):
            w, h = self.sizes[level - 1]
            means = half_resolution(means, 0, h, 0, w)
            self._write(space, write, level, range(len(means)), range(means.shape[1]), means)

    def _average(
        self,
        space: LobedSpace,
        read: ReadCodes,
        write: WriteCodes,
        level: int,
        rows: range,
        columns: range,
    ) -> np.ndarray:
        """Averages (h, w, channels, K) of a part of a level; stores it and all finer levels."""
        if level == 0:
            codes = read(self._indices(0, rows, columns)).astype(np.float32)
            lifted = space.lift(codes.reshape(-1, codes.shape[-1]))
            return lifted.reshape(len(rows), len(columns), self._channels, -1)
        width, height = self.sizes[level - 1]
        finer = self._average(
            space,
            read,
            write,
            level - 1,
            source_rows(rows.start, rows.stop, height),
            source_rows(columns.start, columns.stop, width),
        )
        means = half_resolution(finer, rows.start, height, columns.start, width)
        self._write(space, write, level, rows, columns, means)
        return means

    def _write(
        self,
        space: LobedSpace,
        write: WriteCodes,
        level: int,
        rows: range,
        columns: range,
        means: np.ndarray,
    ) -> None:
        """Store the codes of averages (h, w, channels, K) of a part of a level."""
        codes = space.drop(means.reshape(-1, means.shape[-1]))
        write(
            self._indices(level, rows, columns), codes.reshape(-1, self._channels, codes.shape[-1])
        )

    def _indices(self, level: int, rows: range, columns: range) -> np.ndarray:
        """Indices of a part of a level, row by row."""
        lines = np.arange(rows.start, rows.stop)[:, None] * self.sizes[level][0]
        return (self._first[level] + lines + np.arange(columns.start, columns.stop)).ravel()

    def _rows(self, read: ReadCodes) -> Callable[[np.ndarray], np.ndarray]:
        """From indices of single codes, channel by channel and texel by texel, to codes (n, L)."""

        def codes(index: np.ndarray) -> np.ndarray:
            texel, channel = np.divmod(index, self._channels)
            return read(texel)[np.arange(len(index)), channel]

        return codes


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Width and height of all levels, from the given one to a single texel."""
    levels = [(width, height)]
    while levels[-1] != (1, 1):
        width, height = (max(side // 2, 1) for side in levels[-1])
        levels.append((width, height))
    return levels


def source_rows(top: int, bottom: int, height: int) -> range:
    """Rows of a level of the given height that rows `top` to `bottom` of the next level average.

    The same holds for columns and the width.
    """
    return range(2 * top, 2 * bottom + height % 2) if height > 1 else range(1)


def half_resolution(
    values: np.ndarray, top: int, height: int, left: int = 0, width: int | None = None
) -> np.ndarray:
    """Averages (h, w, ...) over areas of a level's values (H, W, ...): a part of the next level.

    Args:
        values: of the rows and columns that `source_rows` gives.
        top, left: first row and column of the part.
        height, width: of the whole level; by default as wide as `values`.
    """
    width = values.shape[1] if width is None else width
    return _half_along_axis(_half_along_axis(values, 0, top, height), 1, left, width)


def _half_along_axis(values: np.ndarray, axis: int, first: int, count: int) -> np.ndarray:
    """Averages along an axis: of two values, or of three weighted by area if `count` is odd."""
    if count == 1:
        return values
    half = values.shape[axis] // 2
    parts = [_every_second(values, axis, start, half) for start in (0, 1)]
    if count % 2 == 0:
        return 0.5 * (parts[0] + parts[1])
    parts.append(_every_second(values, axis, 2, half))
    shape = [1] * values.ndim
    shape[axis] = half
    index = np.arange(first, first + half, dtype=np.float32).reshape(shape)
    whole = count // 2
    weights = (whole - index) / count, np.float32(whole / count), (index + 1) / count
    return sum(weight * part for weight, part in zip(weights, parts, strict=True))


def _every_second(values: np.ndarray, axis: int, first: int, count: int) -> np.ndarray:
    index: list[slice] = [slice(None)] * values.ndim
    index[axis] = slice(first, first + 2 * count - 1, 2)
    return values[tuple(index)]
