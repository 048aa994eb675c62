"""Axes: the parameters of a material that vary over a surface, places on them, and interpolation.

A material has few parameters that vary. Each is an axis, with nodes over the range of the
parameter. Codes are smooth along the axes, so that linear interpolation between nodes adds little.
Few points of the unit cube are interpolated by radial functions.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urushi.core.namespace import Namespace
from urushi.core.probe_pairs import even_points
from urushi.parallel import fill_blocks

#: Offset of a reflectance in its logarithm.
DARK = 0.01

#: Scales of axes: along which coordinate of a parameter codes are closest to linear.
WIDTH, DEPTH, REFLECTANCE, LINEAR = "width", "depth", "reflectance", "linear"
ALBEDO, INDEX = "albedo", "index"  # of single scattering; relative, above or below one

#: Three changes of a constant, one of which is zero, by which slopes are found.
Changes = tuple[float, float, float]

#: Steps between the values of a coordinate at `points`.
LEVELS = 16

#: Values that are interpolated at once: bounds memory.
BLOCK = 2048

#: Length of a coordinate at first, and its bounds, relative to the range of the coordinate.
LENGTH, SHORTEST, LONGEST = 2.5, 0.1, 50.0

#: Points by which lengths are chosen, and rounds of this choice.
CHOOSING, ROUNDS = 160, 2

#: Added to the diagonal: points may coincide.
RIDGE = 1e-11


class Axis(NamedTuple):
    """The values of one parameter, from least to most."""

    name: str
    scale: str
    least: float
    most: float
    own: bool = False  # whether each channel has a value of its own

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """Numbers by which `coordinate` maps values: the range, and an offset and a factor."""
        first, last = (_scaled(self.scale, x, math) for x in (self.least, self.most))
        return self.least, self.most, first, 1 / (last - first)

    def coordinate(self, value: Any, xp: Namespace, numbers: Sequence[Any] = ()) -> Any:
        """The coordinate of a value, from 0 to 1; values outside the range are its ends.

        numbers: of the axis, by default its own.
        """
        least, most, first, factor = numbers or self.numbers
        value = xp.minimum(xp.maximum(value, least), most)
        return (_scaled(self.scale, value, xp) - first) * factor

    def values(self, coordinates: np.ndarray) -> np.ndarray:
        """The values at coordinates."""
        first, last = (_scaled(self.scale, x, math) for x in (self.least, self.most))
        x = first + (last - first) * coordinates
        if self.scale == REFLECTANCE:
            x = np.exp(x) - DARK
        elif self.scale == ALBEDO:
            x = 1 - x * x
        elif self.scale == INDEX:
            x = (1 + x * abs(x)) / (1 - x * abs(x))
        elif self.scale != LINEAR:
            x = x * x
        return np.clip(x, self.least, self.most)

    def contains(self, other: "Axis") -> bool:
        """Whether another axis is a part of this one."""
        alike = (self.name, self.scale, self.own) == (other.name, other.scale, other.own)
        return alike and self.least <= other.least and other.most <= self.most


def _scaled(scale: str, value: Any, xp: Any) -> Any:
    if scale == REFLECTANCE:
        return xp.log(value + DARK)
    if scale == ALBEDO:
        return -xp.sqrt(1 - value)
    if scale == INDEX:  # the root of Fresnel's amplitude at the normal, with its sign
        amplitude = (value - 1) / (value + 1)
        return amplitude / xp.sqrt(xp.sqrt(amplitude * amplitude + 1e-12))
    return value if scale == LINEAR else xp.sqrt(value)


class Leader(NamedTuple):
    """The parameter of which another one is a function, and this function."""

    name: str
    values: np.ndarray  # (N,) of the leader, ascending
    own: np.ndarray  # (N,) those of the other one

    def at(self, values: np.ndarray) -> np.ndarray:
        """The other parameter at values of the leader."""
        return np.interp(values, self.values, self.own)


class Varying(NamedTuple):
    """A parameter that varies over a surface or carries a gradient."""

    axis: Axis
    #: From a surface interaction and active lanes to its Dr.Jit floats: one, or one a channel.
    read: Callable[[Any, Any], list]
    sources: Sequence[Any] = ()  # the textures on which it depends
    texture: Any = None  # which it is, of a bottom
    differentiable: bool = False  # whether it carries a gradient
    places: np.ndarray | None = None  # of the axis of wavelengths, see `reading.rows`
    #: Changes of a constant that carries a gradient, by which its slopes are found; else None.
    changes: Changes | None = None
    leader: Leader | None = None  # along whose axis it varies, see `reading.varying.joined`


def whole_numbers(x: Any) -> np.ndarray:
    """The whole numbers of arrays of numbers that are not negative."""
    return np.asarray(x).astype(int)


def nearest(shape: Sequence[int], coordinates: Sequence, index: Callable[[Any], Any]) -> Any:
    """The node nearest to coordinates in [0, 1], one on each axis."""
    node = index(0)
    for x, count in zip(coordinates, shape, strict=True):
        node = node * count + index(x * (count - 1) + 0.5)
    return node


def simplex(
    shape: Sequence[int], coordinates: Sequence, index: Callable[[Any], Any], xp: Namespace
) -> list[tuple[Any, Any]]:
    """Nodes and weights of the d + 1 corners of the simplex around d coordinates in [0, 1].

    The cell is cut into the simplices along which coordinates ascend (Kuhn 1960).
    """
    node, step = index(0), math.prod(shape)
    shares, steps = list[Any](), list[Any]()
    for x, count in zip(coordinates, shape, strict=True):
        place = x * (count - 1)
        first = xp.minimum(index(place), count - 2)
        node, step = node * count + first, step // count
        shares.append(place - first)
        steps.append(index(step))
    for end in range(len(shape) - 1, 0, -1):  # in descending order
        for a in range(end):
            swap = shares[a] < shares[a + 1]
            for parts in (shares, steps):
                pair = parts[a : a + 2]
                parts[a : a + 2] = [xp.where(swap, *pair[::-1]), xp.where(swap, *pair)]
    ends, corners = [1.0, *shares, 0.0], []
    for k, step in enumerate([index(0), *steps]):
        node = node + step
        corners.append((node, ends[k] - ends[k + 1]))
    return corners


def points(dimensions: int, count: int) -> np.ndarray:
    """At most `count` points (n, d) of the unit cube: its corners, and others that are denser near
    its ends.

    The others are `even_points`, at `LEVELS` + 1 values of each coordinate: what
    depends on one parameter alone is computed once for each value.
    """
    corners = np.array(list(np.ndindex(*[2] * dimensions)), float)[: count // 2]
    others = np.rint(even_points(count - len(corners), dimensions) * LEVELS) / LEVELS
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
    some = np.random.default_rng(0).permutation(len(x))[:CHOOSING]
    scale = 1 / _lengths(x[some].astype(np.float64), (values[some] @ norm).reshape(len(some), -1))
    x, given = x * scale, values.reshape(len(x), -1)
    weights = np.linalg.solve(_system(x), np.pad(given, [(0, 1), (0, 0)]))

    def at(y: np.ndarray) -> np.ndarray:
        return _multiquadrics(y * scale, x) @ weights[:-1] + weights[-1]

    def found(y: np.ndarray) -> np.ndarray:
        result = np.empty((len(y), given.shape[1]), values.dtype)
        fill_blocks(result, at, y, rows=BLOCK)
        return result.reshape(len(y), *values.shape[1:])

    return found


def _lengths(x: np.ndarray, values: np.ndarray) -> NDArray[np.float64]:
    """The length (d,) of each coordinate of points x (m, d) with values (m, k)."""
    ranges = np.maximum(np.ptp(x, axis=0), 1e-9)

    def error(lengths: np.ndarray) -> float:
        """The mean square of the errors at points that are left out."""
        inverse = np.linalg.inv(_system(x / (lengths * ranges)))[:-1, :-1]
        return float(np.square(inverse @ values / np.diag(inverse)[:, None]).mean())

    lengths = np.full(x.shape[1], LENGTH)
    least = error(lengths)
    for axis, factor in [(a, f) for a in range(x.shape[1]) for f in (0.5, 2.0)] * ROUNDS:
        while True:
            other = lengths.copy()
            other[axis] *= factor
            if not SHORTEST < other[axis] < LONGEST or (now := error(other)) >= least:
                break
            lengths, least = other, now
    return lengths * ranges


def _system(x: np.ndarray) -> np.ndarray:
    """The equations (m + 1, m + 1) of the weights at points (m, d), and of a constant."""
    system = np.pad(_multiquadrics(x, x) + RIDGE * np.eye(len(x)), (0, 1), constant_values=1.0)
    system[-1, -1] = 0
    return system


def _multiquadrics(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Minus sqrt(1 + r^2) (n, m) of the distances r of points y (n, d) from points x (m, d)."""
    squares = np.square(y).sum(axis=1)[:, None] - 2 * y @ x.T + np.square(x).sum(axis=1)
    return -np.sqrt(1 + np.maximum(squares, 0))
