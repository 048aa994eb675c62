"""Polyharmonic splines (Duchon 1977), and points of the unit cube that they interpolate."""

from collections.abc import Callable

import numpy as np

from urushi.parallel import fill_blocks

#: Steps between the values of a coordinate at these points.
LEVELS = 16

#: Points that are interpolated at once: bounds memory.
BLOCK = 2048


def points(dimensions: int, count: int) -> np.ndarray:
    """At most `count` points (n, d) of the unit cube: its corners, and others that are denser near
    its ends.

    The others are a sequence of Roberts (2018), at `LEVELS` + 1 values of each coordinate: what
    depends on one parameter alone is computed once for each value.
    """
    corners = np.array(list(np.ndindex(*[2] * dimensions)), float)[: count // 2]
    ratio = 2.0
    for _ in range(64):  # the root of x^(d + 1) = x + 1
        ratio = (1 + ratio) ** (1 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    others = (0.5 + np.arange(1, count - len(corners) + 1)[:, None] * steps) % 1
    others = np.rint(others * LEVELS) / LEVELS
    return np.unique(np.concatenate([corners, 0.5 - 0.5 * np.cos(np.pi * others)]), axis=0)


def spline(
    x: np.ndarray, values: np.ndarray, degree: int = 1
) -> Callable[[np.ndarray], np.ndarray]:
    """The function of points (n, d) that takes values (m, ...) at x (m, d), in the precision of x.

    It is a sum of distances, and a constant far away; of degree 1, of cubed distances, and linear
    far away. Of points without coordinates, it is a constant.
    """
    if not x.shape[1]:
        return lambda y: np.repeat(values, len(y), axis=0)
    centre = x.mean(axis=0)
    x = x - centre
    squares = np.square(x).sum(axis=1)

    def linear(y: np.ndarray) -> np.ndarray:
        return np.concatenate([np.ones_like(y[:, :1]), y], axis=1)[:, : 1 + degree * y.shape[1]]

    cubes = np.linalg.norm(x[:, None].astype(np.float64) - x, axis=-1) ** (1 + 2 * degree)
    corner = np.zeros((linear(x).shape[1],) * 2)
    system = np.block([[cubes, linear(x)], [linear(x).T, corner]])
    given = np.pad(values.reshape(len(x), -1).astype(np.float64), [(0, len(corner)), (0, 0)])
    # Points may coincide, and their differences be rounding.
    weights = np.linalg.lstsq(system, given, rcond=1e-10)[0].astype(x.dtype)

    def at(y: np.ndarray) -> np.ndarray:
        y = y - centre
        distance2 = np.square(y).sum(axis=1)[:, None] - 2 * y @ x.T + squares
        distance2 = np.maximum(distance2, 0)
        sums = distance2**degree * np.sqrt(distance2)
        return sums @ weights[: len(x)] + linear(y) @ weights[len(x) :]

    def found(y: np.ndarray) -> np.ndarray:
        result = np.empty((len(y), weights.shape[1]), x.dtype)
        fill_blocks(result, at, y, rows=BLOCK)
        return result.reshape(len(y), *values.shape[1:])

    return found
