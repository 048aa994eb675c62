"""Unit vectors, most of them above the horizon, float32 (N, 3)."""

import numpy as np

#: Mirrors directions at the surface.
DOWN = np.array([1, 1, -1], np.float32)


def above(count: int, seed, least_cosine: float = 0.0) -> np.ndarray:
    """Uniform above a cosine; the seed may be a generator."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(least_cosine, 1, count)
    phi = rng.uniform(0, 2 * np.pi, count)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], 1).astype(np.float32)


def pairs_above(count: int, seed, least_cosine: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Two such arrays."""
    return tuple(above(2 * count, seed, least_cosine).reshape(2, count, 3))


def at_cosines(cosines, azimuth=0.0) -> np.ndarray:
    """With cosines of the angle to the normal, at azimuths [radians]."""
    z, phi = np.broadcast_arrays(np.asarray(cosines, float), azimuth)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)


def in_plane(degrees) -> np.ndarray:
    """At angles to the normal, in the xz plane."""
    polar = np.radians(degrees)
    return np.stack([np.sin(polar), 0 * polar, np.cos(polar)], axis=-1).astype(np.float32)


def hemisphere(count: int, seed: int) -> np.ndarray:
    """Above the horizon, a third of them grazing."""
    w = np.random.default_rng(seed).normal(size=(count, 3))
    w[::3, 2] *= 1e-2
    return _upward(w)


def pairs_near_mirrors(count: int = 4096) -> tuple[np.ndarray, np.ndarray]:
    """Pairs, half of them close to mirror directions."""
    wi, wo = hemisphere(count, 1), hemisphere(count, 2)
    noise = np.random.default_rng(3).normal(size=(count, 3)) * 0.01
    wo[::2] = _upward(wi * [-1, -1, 1] + noise)[::2]
    return wi, wo


def _upward(w: np.ndarray) -> np.ndarray:
    w = w * [1, 1, 0] + np.abs(w) * [0, 0, 1]
    return (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)
