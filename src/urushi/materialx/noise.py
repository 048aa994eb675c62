"""Noise of MaterialX's standard library in two dimensions, on NumPy arrays.

The functions are those of Open Shading Language, as MaterialX defines them: gradient noise (Perlin,
Improving noise, SIGGRAPH 2002) on Jenkins' integer hash (lookup3, 2006), cell noise and cellular
noise (Worley, SIGGRAPH 1996). Positions are arrays (..., 2).
"""

import numpy as np

#: Factor by which two-dimensional gradient noise comes close to [-1, 1].
_SCALE = 0.6616

#: Offsets of the positions of further channels.
_NOISE_OFFSET = np.array([19.0, 73.0])
_FRACTAL_OFFSET = np.array([19.0, 193.0])


def _cell(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The integer part of numbers, as int64, and the rest."""
    whole = np.floor(x)
    return np.clip(whole, -(2.0**31), 2.0**31 - 1).astype(np.int64), x - whole


def _rotate(x: np.ndarray, bits: int) -> np.ndarray:
    return (x << np.uint32(bits)) | (x >> np.uint32(32 - bits))


def hash_integers(*numbers: np.ndarray) -> np.ndarray:
    """Jenkins' hash of one to three integers, uint32."""
    seed = (0xDEADBEEF + (len(numbers) << 2) + 13) & 0xFFFFFFFF
    shape = np.broadcast_shapes(*(np.shape(n) for n in numbers))
    a, b, c = (np.full(shape or (1,), seed, np.uint32) for _ in range(3))
    for word, number in zip((a, b, c), numbers, strict=False):
        word += np.asarray(number).astype(np.uint32)
    c ^= b
    c -= _rotate(b, 14)
    a ^= c
    a -= _rotate(c, 11)
    b ^= a
    b -= _rotate(a, 25)
    c ^= b
    c -= _rotate(b, 16)
    a ^= c
    a -= _rotate(c, 4)
    b ^= a
    b -= _rotate(a, 14)
    c ^= b
    c -= _rotate(b, 24)
    return c.reshape(shape)


def _gradient(code: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The product of (x, y) with one of eight gradients (±1, ±2), (±2, ±1)."""
    low = (code & np.uint32(7)) < 4
    u, v = np.where(low, x, y), 2 * np.where(low, y, x)
    return np.where(code & np.uint32(1), -u, u) + np.where(code & np.uint32(2), -v, v)


def _perlin(p: np.ndarray, shifts: tuple[int, ...], mask: int) -> np.ndarray:
    """Gradient noise, one channel for each shift of the hash."""
    (x, fx), (y, fy) = _cell(p[..., 0]), _cell(p[..., 1])
    u, v = (t**3 * (t * (t * 6 - 15) + 10) for t in (fx, fy))
    corners = {}
    for i in (0, 1):
        for j in (0, 1):
            code = hash_integers(x + i, y + j)
            channels = [(code >> np.uint32(shift)) & np.uint32(mask) for shift in shifts]
            corners[i, j] = np.stack([_gradient(c, fx - i, fy - j) for c in channels], axis=-1)
    u, v = u[..., None], v[..., None]
    top = (1 - u) * corners[0, 0] + u * corners[1, 0]
    bottom = (1 - u) * corners[0, 1] + u * corners[1, 1]
    return _SCALE * ((1 - v) * top + v * bottom)


def _perlin_one(p: np.ndarray) -> np.ndarray:
    return _perlin(p, (0,), 0xFFFFFFFF)


def _perlin_three(p: np.ndarray) -> np.ndarray:
    return _perlin(p, (0, 8, 16), 0xFF)


def perlin(p: np.ndarray, channels: int) -> np.ndarray:
    """Gradient noise at positions (..., 2), of 1 to 4 channels, about [-1, 1]."""
    if channels == 1:
        return _perlin_one(p)
    three = _perlin_three(p)
    if channels == 4:
        return np.concatenate([three, _perlin_one(p + _NOISE_OFFSET)], axis=-1)
    return three[..., :channels]


def fractal(
    p: np.ndarray, channels: int, octaves: int, lacunarity: np.ndarray, diminish: np.ndarray
) -> np.ndarray:
    """A sum of octaves of gradient noise, of 1 to 4 channels.

    Two channels are two single ones, the second of a shifted position.
    """

    def octave_sum(noise, position):
        total, amplitude = np.zeros(1), np.ones(1)
        for _ in range(octaves):
            total = total + amplitude * noise(position)
            amplitude = amplitude * diminish
            position = position * lacunarity
        return total

    if channels == 1:
        return octave_sum(_perlin_one, p)
    if channels == 3:
        return octave_sum(_perlin_three, p)
    first = _perlin_one if channels == 2 else _perlin_three
    parts = (octave_sum(first, p), octave_sum(_perlin_one, p + _FRACTAL_OFFSET))
    return np.concatenate(
        [np.broadcast_to(part, (*p.shape[:-1], part.shape[-1])) for part in parts], -1
    )


def _unit(code: np.ndarray) -> np.ndarray:
    return code / np.float64(0xFFFFFFFF)


def cell(p: np.ndarray) -> np.ndarray:
    """A random number in [0, 1] for each cell of the integer grid, (..., 1)."""
    return _unit(hash_integers(_cell(p[..., 0])[0], _cell(p[..., 1])[0]))[..., None]


def _cell_three(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.stack([_unit(hash_integers(x, y, np.array(k))) for k in range(3)], axis=-1)


def worley(p: np.ndarray, channels: int, jitter: np.ndarray, style: int) -> np.ndarray:
    """Cellular noise of 1 to 3 channels.

    Args:
        p: positions (..., 2).
        jitter: how far points lie from the centres of their cells, 1: anywhere inside.
        style: 0: distances to the nearest points; 1: random numbers of the nearest point's cell.
    """
    (x, fx), (y, fy) = _cell(p[..., 0]), _cell(p[..., 1])
    jitter = np.broadcast_to(np.asarray(jitter), (*p.shape[:-1], 1))
    nearest = np.full((*p.shape[:-1], channels), 1e6)
    offset = np.zeros(p.shape)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            random = _cell_three(x + i, y + j)[..., :2]
            point = (random - 0.5) * jitter + 0.5 + np.array([i, j])
            difference = point - np.stack([fx, fy], axis=-1)
            square = (difference**2).sum(-1, keepdims=True)
            offset = np.where(square < nearest[..., :1], difference, offset)
            nearest = np.sort(np.concatenate([nearest, square], -1), -1)[..., :channels]
    if style == 1:
        there = p + offset
        if channels == 1:
            return cell(there)
        cells = (_cell(there[..., 0])[0], _cell(there[..., 1])[0])
        return _cell_three(*cells)[..., :channels]
    return np.sqrt(nearest)
