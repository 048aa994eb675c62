"""Cubic Bézier outlines of turned shapes, and tubes of mirrored bicubic patches (Bézier 1968)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Outline:
    """Half of a turned shape's outline: joined cubic segments, taken as `turned.Profile` is.

    Attributes:
        control: (3 S + 1, 2) control points (radius, height) of S segments, from the bottom up.
    """

    control: np.ndarray

    def __call__(self, v: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Points and unit tangents, each of v's shape + (2,); every segment takes as much of v."""
        segments = (len(self.control) - 1) // 3
        at = np.asarray(v, float) * segments
        first = np.clip(at.astype(int), 0, segments - 1)
        t = (at - first)[..., None]
        a, b, c, d = (self.control[3 * first + k] for k in range(4))
        points = _curve(a, b, c, d, t)
        tangents = (1 - t) ** 2 * (b - a) + 2 * (1 - t) * t * (c - b) + t**2 * (d - c)
        return points, tangents / np.linalg.norm(tangents, axis=-1, keepdims=True)


@dataclass(frozen=True)
class Tube:
    """A closed tube that is its own mirror image in y, given by its half with y <= 0.

    Attributes:
        control: (3 S + 1, 4, 3): across the tube four control points, from y = 0 round to y = 0;
            along it S joined segments.
    """

    control: np.ndarray

    def __call__(self, u: npt.ArrayLike, v: npt.ArrayLike) -> np.ndarray:
        """Points (..., 3) at u around and v along the tube, both in [0, 1]."""
        u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
        segments = (len(self.control) - 1) // 3
        at = v * segments
        first = np.clip(at.astype(int), 0, segments - 1)
        t = (at - first)[..., None]
        s = np.where(u < 0.5, 2 * u, 2 - 2 * u)[..., None]
        a, b, c, d = (self.control[3 * first + k] for k in range(4))
        across = np.moveaxis(_curve(a, b, c, d, t[..., None]), -2, 0)
        points = _curve(across[0], across[1], across[2], across[3], s)
        return points * np.where(u[..., None] < 0.5, 1, [1, -1, 1])


def _curve(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, t: np.ndarray) -> np.ndarray:
    """A cubic Bézier curve at t."""
    s = 1 - t
    return s**3 * a + 3 * s**2 * t * b + 3 * s * t**2 * c + t**3 * d
