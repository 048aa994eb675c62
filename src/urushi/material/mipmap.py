"""Mip maps of latent textures: levels of half the resolution, averages of the level before.

Levels are averages of codes, as in Fan et al. (2022), but for the gain, see `brightness`. BRDFs do
not average as their codes do; `benchmarks/mipmap.py` measures by how much.
"""

import numpy as np

from urushi.material.brightness import Brightness


def sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Width and height of all levels, from the given one to a single texel."""
    levels = [(width, height)]
    while levels[-1] != (1, 1):
        width, height = (max(side // 2, 1) for side in levels[-1])
        levels.append((width, height))
    return levels


def sources(top: int, bottom: int, height: int) -> range:
    """The rows of a level of some height that the rows from top to bottom of the next one need."""
    return range(2 * top, 2 * bottom + height % 2) if height > 1 else range(1)


def coarser(codes: np.ndarray, top: int, height: int, brightness: Brightness | None) -> np.ndarray:
    """The next level's codes (h, w, ..., size), of a level's (H, W, ..., size), as `halved`.

    Their gain keeps the light; without a measure of brightness it is an average as the rest.
    """
    averages = halved(codes, top, height)
    if brightness is not None:
        light = np.exp(codes[..., 0] + _each(brightness, codes))
        mean = np.log(halved(light, top, height))
        averages[..., 0] = mean - _each(brightness, averages)
    return averages


def _each(brightness: Brightness, codes: np.ndarray) -> np.ndarray:
    return brightness(codes.reshape(-1, codes.shape[-1])).reshape(codes.shape[:-1])


def halved(values: np.ndarray, top: int, height: int) -> np.ndarray:
    """Averages (h, max(W // 2, 1), ...) of a level's values (H, W, ...) over areas.

    values: of the rows that `sources` tells, for the next level's rows from `top` on; height: that
    of the whole level.
    """
    return _halved(_halved(values, 0, top, height), 1, 0, values.shape[1])


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
