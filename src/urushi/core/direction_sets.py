"""Random sets of direction pairs.

Every set is drawn in double precision from a generator that the caller seeds, and returned as
float32 unit vectors wi, wo of shape (n, 3), z the normal, both above the horizon.
"""

from collections.abc import Callable

import numpy as np

Pairs = tuple[np.ndarray, np.ndarray]


def cosine_pairs(rng: np.random.Generator, n: int, *, lowest_cosine: float = 0.0) -> Pairs:
    """Pairs of independent directions, both of density cos(theta) / pi, as for the error E."""

    def draw(count: int) -> Pairs:
        wi, wo = (direction(np.sqrt(rng.random(count)), rng.random(count)) for _ in range(2))
        return wi, wo

    return accepted(draw, n, lowest_cosine)


def accepted(draw: Callable[[int], Pairs], n: int, lowest_cosine: float) -> Pairs:
    """Draw until `n` pairs have both cosines above `lowest_cosine`, in the order drawn."""
    wi, wo = np.empty((0, 3), np.float32), np.empty((0, 3), np.float32)
    while len(wi) < n:
        new_wi, new_wo = (w.astype(np.float32) for w in draw(n))
        keep = np.minimum(new_wi[:, 2], new_wo[:, 2]) > lowest_cosine
        wi, wo = np.concatenate([wi, new_wi[keep]]), np.concatenate([wo, new_wo[keep]])
    return wi[:n], wo[:n]


def direction(cosine: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) of the given cosine, at azimuth 2 pi u."""
    sine = np.sqrt(np.maximum(0.0, 1 - cosine * cosine))
    return np.stack([sine * np.cos(2 * np.pi * u), sine * np.sin(2 * np.pi * u), cosine], -1)
