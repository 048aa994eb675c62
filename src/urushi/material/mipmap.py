"""Mip maps: levels of half the resolution, averages of the level before over areas."""

import numpy as np


def sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Width and height of all levels, from the given one to a single texel."""
    levels = [(width, height)]
    while levels[-1] != (1, 1):
        width, height = (max(side // 2, 1) for side in levels[-1])
        levels.append((width, height))
    return levels


def sources(top: int, bottom: int, height: int) -> range:
    """The rows of a level of some height that the rows from top to bottom of the next one need.

    Columns likewise, by the width.
    """
    return range(2 * top, 2 * bottom + height % 2) if height > 1 else range(1)


def halved(
    values: np.ndarray, top: int, height: int, left: int = 0, width: int | None = None
) -> np.ndarray:
    """Averages (h, w, ...) of a level's values (H, W, ...) over areas.

    values: of the rows and columns that `sources` tells, for the next level's rows from `top` and
    columns from `left` on; height, width: those of the whole level, by default as wide as values.
    """
    width = values.shape[1] if width is None else width
    return _halved(_halved(values, 0, top, height), 1, left, width)


def _halved(values: np.ndarray, axis: int, first: int, count: int) -> np.ndarray:
    """Averages along an axis: of two values each, or of three by the areas that they share."""
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
