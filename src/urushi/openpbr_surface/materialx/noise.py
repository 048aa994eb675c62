"""Noise of MaterialX's standard library in two and three dimensions, on NumPy arrays.

The functions are those of Open Shading Language, as MaterialX defines them: gradient noise (Perlin,
Improving noise, SIGGRAPH 2002) on Jenkins' integer hash (lookup3, 2006), cell noise and cellular
noise (Worley, SIGGRAPH 1996). Positions are arrays (..., 2) or (..., 3).
"""

from collections.abc import Callable
from itertools import product

import numpy as np

#: Factor by which gradient noise comes close to [-1, 1], by the number of dimensions.
_SCALE = {2: 0.6616, 3: 0.9820}

#: Offsets of the positions of further channels.
_NOISE_OFFSET = np.array([19.0, 73.0, 29.0])
_FRACTAL_OFFSET = np.array([19.0, 193.0, 17.0])


def _cell(p: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """The integer parts of positions (..., D), int64 for each coordinate, and the rest (..., D)."""
    whole = np.floor(p)
    integers = np.clip(whole, -(2.0**31), 2.0**31 - 1).astype(np.int64)
    return [integers[..., k] for k in range(p.shape[-1])], p - whole


def _rotate(x: np.ndarray, bits: int) -> np.ndarray:
    return (x << np.uint32(bits)) | (x >> np.uint32(32 - bits))


def hash_integers(*numbers: np.ndarray) -> np.ndarray:
    """Jenkins' hash of one to four integers, uint32 (...,), at least (1,)."""
    start = np.uint32((0xDEADBEEF + 4 * len(numbers) + 13) & 0xFFFFFFFF)
    missing = np.zeros(2, np.uint32)[:, None]
    given = [np.atleast_1d(n).astype(np.uint32) for n in (*numbers, *missing)]
    a, b, c = (start + n for n in given[:3])
    if len(numbers) > 3:
        for bits in (4, 6, 8, 16, 19, 4):  # reversible mixing of three words
            a, b, c = b, c + b, (a - c) ^ _rotate(c, bits)
        a = a + given[3]
    for bits in (14, 11, 25, 16, 4, 14, 24):  # the final mixing; the last word is the hash
        a, b, c = b, (c ^ b) - _rotate(b, bits), a
    return b


def _gradient(code: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The product of p (..., D) with a gradient: (±1, ±2), (±2, ±1), or to an edge of a cube."""
    x, y = p[..., 0], p[..., 1]
    if p.shape[-1] == 2:
        low = (code & np.uint32(7)) < 4
        u, v = np.where(low, x, y), 2 * np.where(low, y, x)
    else:
        h = code & np.uint32(15)
        u = np.where(h < 8, x, y)
        v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, p[..., 2]))
    return np.where(code & np.uint32(1), -u, u) + np.where(code & np.uint32(2), -v, v)


def _perlin(p: np.ndarray, channels: int) -> np.ndarray:
    """Gradient noise of one channel or three, of the bits of the hash from 0, 8 and 16."""
    shifts = (0, 8, 16)[:channels]
    cell, inside = _cell(p)
    fade = inside**3 * (inside * (inside * 6 - 15) + 10)
    total = np.zeros((*p.shape[:-1], len(shifts)))
    for corner in product((0, 1), repeat=p.shape[-1]):
        code = hash_integers(*(x + i for x, i in zip(cell, corner, strict=True)))
        weight = np.where(corner, fade, 1 - fade).prod(-1)[..., None]
        slopes = [_gradient(code >> np.uint32(shift), inside - corner) for shift in shifts]
        total += weight * np.stack(slopes, axis=-1)
    return _SCALE[p.shape[-1]] * total


def _channels(noise, p: np.ndarray, channels: int, offset: np.ndarray) -> np.ndarray:
    """Channels of a noise of one or three: the last of two or four is of a shifted position."""
    if channels in (1, 3):
        return noise(p, channels)
    return np.concatenate([noise(p, channels - 1), noise(p + offset[: p.shape[-1]], 1)], axis=-1)


def _of_constants(noise: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """A noise at positions (N, D) that takes one position (D,), too."""

    def at(p: np.ndarray, *others) -> np.ndarray:
        value = noise(np.atleast_2d(p), *others)
        return value if len(value) > 1 else value[0]

    return at


@_of_constants
def perlin(p: np.ndarray, channels: int) -> np.ndarray:
    """Gradient noise at positions (..., D), of 1 to 4 channels, about [-1, 1]."""
    if channels == 2:
        return _perlin(p, 3)[..., :2]
    return _channels(_perlin, p, channels, _NOISE_OFFSET)


@_of_constants
def fractal(
    p: np.ndarray, channels: int, octaves: int, lacunarity: np.ndarray, diminish: np.ndarray
) -> np.ndarray:
    """A sum of octaves of gradient noise, of 1 to 4 channels."""

    def octave_sum(position, channels):
        total, amplitude = np.zeros((*position.shape[:-1], channels)), np.ones(1)
        for _ in range(octaves):
            total = total + amplitude * _perlin(position, channels)
            amplitude = amplitude * diminish
            position = position * lacunarity
        return total

    return _channels(octave_sum, p, channels, _FRACTAL_OFFSET)


def _unit(code: np.ndarray) -> np.ndarray:
    return code / np.float64(0xFFFFFFFF)


@_of_constants
def cell(p: np.ndarray) -> np.ndarray:
    """A random number in [0, 1] for each cell of the integer grid, (..., 1)."""
    return _unit(hash_integers(*_cell(p)[0]))[..., None]


def _cell_three(*cell: np.ndarray) -> np.ndarray:
    return np.stack([_unit(hash_integers(*cell, np.array(k))) for k in range(3)], axis=-1)


@_of_constants
def worley(p: np.ndarray, channels: int, jitter: np.ndarray, style: int) -> np.ndarray:
    """Cellular noise of 1 to 3 channels.

    Args:
        p: positions (..., D).
        jitter: how far points lie from the centres of their cells, 1: anywhere inside.
        style: 0: distances to the nearest points; 1: random numbers of the nearest point's cell.
    """
    p = p + 0 * jitter  # of one shape
    corner, inside = _cell(p)
    nearest = np.full((*p.shape[:-1], channels), 1e6)
    offset = np.zeros(p.shape)
    for step in product((-1, 0, 1), repeat=p.shape[-1]):
        random = _cell_three(*(x + i for x, i in zip(corner, step, strict=True)))
        point = (random[..., : p.shape[-1]] - 0.5) * jitter + 0.5 + np.array(step)
        square = ((point - inside) ** 2).sum(-1, keepdims=True)
        offset = np.where(square < nearest[..., :1], point - inside, offset)
        nearest = np.sort(np.concatenate([nearest, square], -1), -1)[..., :channels]
    if style == 1:
        there = p + offset
        return cell(there) if channels == 1 else _cell_three(*_cell(there)[0])[..., :channels]
    return np.sqrt(nearest)
