"""Interpolation by radial functions, and points of the unit cube that they interpolate."""

import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from urushi.core.probe_pairs import even_points
from urushi.parallel import fill_blocks

#: Values that are interpolated at once: bounds memory.
BLOCK = 2048

#: Length of a coordinate at first, and its bounds, relative to the range of the coordinate.
LENGTH, SHORTEST, LONGEST = 2.5, 0.1, 50.0

#: Rounds in which lengths are chosen: by how many points at most, and the factor of a change.
ROUNDS = (160, 2.0), (1024, 1.5)

#: Added to the diagonal: points may coincide.
RIDGE = 1e-11


def points(levels: Sequence[int], count: int) -> np.ndarray:
    """At most `count` points (n, d) of the unit cube: its corners, and others that are denser near
    its ends.

    The others are `even_points`. A coordinate has one value more than its `levels`: what depends
    on one parameter alone is computed once for each value.
    """
    corners = np.array(list(np.ndindex(*[2] * len(levels))), float)[: count // 2]
    others = np.rint(even_points(count - len(corners), len(levels)) * levels) / levels
    return np.unique(np.concatenate([corners, 0.5 - 0.5 * np.cos(np.pi * others)]), axis=0)


def interpolant(
    x: np.ndarray, values: np.ndarray, norm: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """The function of points (n, d) that takes values (m, ..., K) at x (m, d).

    It is a sum of multiquadrics (Hardy 1971) and a constant. Each coordinate has a length, over
    which the function changes little. Lengths minimise the errors at points that are left out one
    by one (Rippa 1999). Of points without coordinates, the function is a constant.

    norm: (K, K) by which an error e of values has the size |e norm|.
    """
    if not x.shape[1]:
        return lambda y: np.repeat(values, len(y), axis=0)
    scale = 1 / _lengths(x, values, norm)[0]
    x, given = x * scale, values.reshape(len(x), -1)
    weights = np.linalg.solve(_system(x), np.pad(given, [(0, 1), (0, 0)]))

    def at(y: np.ndarray) -> np.ndarray:
        return _multiquadrics(y * scale, x) @ weights[:-1] + weights[-1]

    def found(y: np.ndarray) -> np.ndarray:
        result = np.empty((len(y), given.shape[1]), values.dtype)
        fill_blocks(result, at, y, rows=BLOCK)
        return result.reshape(len(y), *values.shape[1:])

    return found


def left_out(x: np.ndarray, values: np.ndarray, norm: np.ndarray) -> float:
    """Root of the mean square error of `interpolant` at a point that it does not know."""
    return _lengths(x, values, norm)[1] ** 0.5


def _lengths(
    x: np.ndarray, values: np.ndarray, norm: np.ndarray
) -> tuple[NDArray[np.float64], float]:
    """The length (d,) of each coordinate, and the mean square error at points that are left out."""
    order = np.random.default_rng(0).permutation(len(x))
    x, values = x[order].astype(np.float64), (values[order] @ norm).reshape(len(x), -1)
    ranges = np.maximum(np.ptp(x, axis=0), 1e-9)

    def error(lengths: np.ndarray, count: int) -> float:
        """The mean square of the errors at points that are left out, of the first ones."""
        inverse = np.linalg.inv(_system(x[:count] / (lengths * ranges)))[:-1, :-1]
        mistakes = inverse @ values[:count] / np.diag(inverse)[:, None]
        return float(np.square(mistakes).sum(axis=1).mean())

    lengths = np.full(x.shape[1], LENGTH)
    for count, step in ROUNDS:
        least = error(lengths, count)
        for axis, factor in itertools.product(range(x.shape[1]), (1 / step, step)):
            while True:
                other = lengths.copy()
                other[axis] *= factor
                if not SHORTEST < other[axis] < LONGEST or (now := error(other, count)) >= least:
                    break
                lengths, least = other, now
    return lengths * ranges, least


def _system(x: np.ndarray) -> np.ndarray:
    """The equations (m + 1, m + 1) of the weights at points (m, d), and of a constant."""
    system = np.pad(_multiquadrics(x, x) + RIDGE * np.eye(len(x)), (0, 1), constant_values=1.0)
    system[-1, -1] = 0
    return system


def _multiquadrics(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Minus sqrt(1 + r^2) (n, m) of the distances r of points y (n, d) from points x (m, d)."""
    squares = np.square(y).sum(axis=1)[:, None] - 2 * y @ x.T + np.square(x).sum(axis=1)
    return -np.sqrt(1 + np.maximum(squares, 0))
