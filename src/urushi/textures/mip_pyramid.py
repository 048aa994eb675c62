"""The mip pyramid of a latent texture: codes of BRDFs averaged over areas, level by level.

Each level is averaged from the level below (`textures.averaging`), in bands of rows, on all cores.
"""

import itertools
from collections.abc import Callable

import numpy as np

from urushi import parallel
from urushi.nets.weights import Model
from urushi.textures.averaging import dropped, lifted

#: Number of texels that are averaged at once, in whole rows: their numbers stay in a core's cache.
BAND_TEXELS = 1 << 10

#: From indices (n,) of texels to their codes (n, channels, size).
ReadCodes = Callable[[np.ndarray], np.ndarray]


def coarse_levels(model: Model, width: int, height: int, read: ReadCodes) -> np.ndarray:
    """Codes float32 (n, channels, size) of all levels but the first, from the finest.

    width, height: of the first level. read: reads codes of the first level, from several threads.
    """

    def first(index: np.ndarray) -> np.ndarray:
        return _of_each_code(lambda z: lifted(model, z), read(index).astype(np.float32))

    numbers: Callable[[np.ndarray], np.ndarray] = first
    levels = [read(np.arange(0)).astype(np.float32)]  # none if the first level is one texel
    for finer, (_, h) in itertools.pairwise(level_sizes(width, height)):
        means = _means(numbers, finer, h)
        codes = np.empty((len(means), means.shape[1], model.arch.latent), np.float32)
        parallel.fill_blocks(codes, lambda x: _of_each_code(lambda m: dropped(model, m), x), means)
        levels.append(codes)
        numbers = means.__getitem__
    return np.concatenate(levels)


def _means(
    numbers: Callable[[np.ndarray], np.ndarray], finer: tuple[int, int], height: int
) -> np.ndarray:
    """Averages (n, channels, K) for a level of this height, from numbers of the finer level."""
    from_w, from_h = finer
    bands = np.array_split(np.arange(height), max(from_w * from_h // BAND_TEXELS, 1))
    bands = [band for band in bands if len(band)]
    parts: list[np.ndarray] = [np.empty(0)] * len(bands)

    def average(index: int) -> None:
        top, bottom = bands[index][0], bands[index][-1] + 1
        rows = source_rows(top, bottom, from_h)
        of_rows = numbers(np.arange(rows.start * from_w, rows.stop * from_w))
        of_rows = of_rows.reshape(len(rows), from_w, *of_rows.shape[1:])
        means = half_resolution(of_rows, top, from_h)
        parts[index] = means.reshape(-1, *means.shape[2:])

    parallel.run_all_cores(average, range(len(bands)))
    return np.concatenate(parts)


def _of_each_code(function: Callable[[np.ndarray], np.ndarray], rows: np.ndarray) -> np.ndarray:
    """A function of rows (n, K), for texels (n, channels, K)."""
    return function(rows.reshape(-1, rows.shape[-1])).reshape(*rows.shape[:2], -1)


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Width and height of all levels, from the given one to a single texel."""
    levels = [(width, height)]
    while levels[-1] != (1, 1):
        width, height = (max(side // 2, 1) for side in levels[-1])
        levels.append((width, height))
    return levels


def source_rows(top: int, bottom: int, height: int) -> range:
    """Rows of a level of the given height that rows `top` to `bottom` of the next level average."""
    return range(2 * top, 2 * bottom + height % 2) if height > 1 else range(1)


def half_resolution(values: np.ndarray, top: int, height: int) -> np.ndarray:
    """Averages (h, w, ...) over areas of a level's values (H, W, ...): rows of the next level.

    values: of the rows that `source_rows` gives. top: first row. height: of the whole level.
    """
    return _half_along_axis(_half_along_axis(values, 0, top, height), 1, 0, values.shape[1])


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
