"""Axes: the parameters of a material that vary over a surface, and places on them.

A material has few parameters that vary. Each is an axis, with nodes over the range of the
parameter. Codes are smooth along the axes, so that linear interpolation between nodes adds little.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.core.namespace import Namespace

#: Offset of a reflectance in its logarithm.
DARK = 0.01

#: Optical depth beyond which media look more and more alike.
DEEP = 8.0

#: Offset of a medium's albedo in its logarithm.
FAINT_ALBEDO = 0.1

#: Scales of axes: along which coordinate of a parameter codes are closest to linear.
WIDTH, DEPTH, REFLECTANCE, LINEAR = "width", "depth", "reflectance", "linear"
ALBEDO, INDEX = "albedo", "index"  # of single scattering; relative, above or below one

#: Values of most parameters at which materials are computed, less one.
LEVELS = 16

#: Three changes of a constant, one of which is zero, by which slopes are found.
Changes = tuple[float, float, float]


class Axis(NamedTuple):
    """The values of one parameter, from least to most."""

    name: str
    scale: str
    least: float
    most: float
    own: bool = False  # whether each channel has a value of its own
    levels: int = LEVELS  # values at which materials are computed, less one

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
            x = 1 - (1 + FAINT_ALBEDO - np.exp(x)) ** 4
        elif self.scale == INDEX:
            x = (1 + x * abs(x)) / (1 - x * abs(x))
        elif self.scale == DEPTH:
            x = x * x / (1 - x * x * (1 / DEEP))
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
    if scale == ALBEDO:  # dense towards zero, and where deep media have lost little light
        return xp.log(1 + FAINT_ALBEDO - xp.sqrt(xp.sqrt(1 - value)))
    if scale == DEPTH:
        return xp.sqrt(value / (1 + value * (1 / DEEP)))
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
    #: Of the axis of wavelengths: places on it, and the wavelengths there [nm], (2, N).
    places: np.ndarray | None = None
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
