"""Procedural patterns in space: gradient noise, fractal noise and cells."""

import numpy as np

_TABLE_BITS = 12


def fractal(
    points: np.ndarray, octaves: int = 5, *, seed: int = 0, gain: float = 0.5
) -> np.ndarray:
    """Octaves of gradient noise, each of twice the frequency and `gain` times the amplitude.

    Args:
        points: (..., 3); features of the first octave are about one unit in size.
        octaves: number of terms.
        seed: chooses the pattern.
        gain: ratio of the amplitudes of successive octaves.

    Returns:
        (...) float32 with mean about 0, mostly within [-1, 1].
    """
    total, size = np.zeros(points.shape[:-1], np.float32), 1.0
    for octave in range(octaves):
        shift = 17.3 * octave  # otherwise lattice points of all octaves would coincide
        total += size * gradient(points * 2.0**octave + shift, seed=seed + octave)
        size *= gain
    return total * (1 - gain) / (1 - gain**octaves) * 1.5


def gradient(points: np.ndarray, *, seed: int = 0) -> np.ndarray:
    """Gradient noise (Perlin 1985, with the quintic weights of Perlin 2002) at points (..., 3)."""
    rng = np.random.default_rng(seed)
    slopes = rng.normal(size=(1 << _TABLE_BITS, 3))
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    slopes = slopes.astype(np.float32)
    cell = np.floor(points)
    x, y, z = np.moveaxis((points - cell).astype(np.float32), -1, 0)
    weights = [t**3 * (t * (6 * t - 15) + 10) for t in (x, y, z)]
    cell = cell.astype(np.int64)
    total = np.zeros(points.shape[:-1], np.float32)
    for i, j, k in np.ndindex(2, 2, 2):
        slope = slopes[_hash(cell + np.array([i, j, k]))]
        ramp = slope[..., 0] * (x - i) + slope[..., 1] * (y - j) + slope[..., 2] * (z - k)
        for weight, far in zip(weights, (i, j, k), strict=True):
            ramp *= weight if far else 1 - weight
        total += ramp
    return 1.6 * total  # a cell's extremes are about +-0.6


def cells(points: np.ndarray, *, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Distances from points (..., 3) to the nearest and the second nearest seed.

    One seed lies at random in each unit cell (Worley 1996). The difference of both distances is
    zero on the borders between the seeds' regions.
    """
    places = np.random.default_rng(seed).random((1 << _TABLE_BITS, 3))
    cell = np.floor(points).astype(np.int64)
    first = np.full(points.shape[:-1], np.inf)
    second = first.copy()
    for neighbour in np.ndindex(3, 3, 3):
        corner = cell + np.array(neighbour) - 1
        distance = np.linalg.norm(corner + places[_hash(corner)] - points, axis=-1)
        second = np.minimum(second, np.maximum(first, distance))
        first = np.minimum(first, distance)
    return first, second


def _hash(cell: np.ndarray) -> np.ndarray:
    """Table indices of lattice cells (..., 3): the primes of Teschner et al. 2003, then mixed."""
    x = cell[..., 0] * 73856093 ^ cell[..., 1] * 19349663 ^ cell[..., 2] * 83492791
    x = (x ^ (x >> 13)) * 0x5BD1E995
    return (x ^ (x >> 15)) & ((1 << _TABLE_BITS) - 1)
