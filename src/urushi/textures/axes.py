"""Materials over axes of parameters: codes at nodes, between which renderers interpolate.

A material has few parameters that vary over a surface. Each is an axis, with nodes over the range
of the parameter. Light transport is computed at some hundred points, which a polyharmonic spline
(Duchon 1977) interpolates to the nodes. Codes are smooth along the axes, so that linear
interpolation between nodes adds little. The lobe of the coat is known at every point, and has no
nodes.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc

from urushi.core.namespace import Namespace
from urushi.material.energy import limit_albedo
from urushi.nets.weights import Model

#: Nodes of each axis, and points of transport, by the number of axes.
NODES = {1: 65, 2: 33, 3: 17, 4: 11}
POINTS = {1: 24, 2: 128, 3: 320, 4: 512}

#: Offset of a reflectance in its logarithm.
DARK = 0.05

#: Scales of axes: along which coordinate of a parameter codes are closest to linear.
WIDTH, DEPTH, REFLECTANCE, LINEAR = "width", "depth", "reflectance", "linear"


class Axis(NamedTuple):
    """The values of one parameter, from least to most."""

    name: str
    scale: str
    least: float
    most: float
    own: bool = False  # whether each channel has a value of its own

    def coordinate(self, value: Any, xp: Namespace) -> Any:
        """The coordinate of a value, from 0 to 1; values outside the range are its ends."""
        first, last = (_scaled(self.scale, x, math) for x in (self.least, self.most))
        value = xp.minimum(xp.maximum(value, self.least), self.most)
        return (_scaled(self.scale, value, xp) - first) * (1 / (last - first))

    def values(self, coordinates: np.ndarray) -> np.ndarray:
        """The values at coordinates."""
        first, last = (_scaled(self.scale, x, math) for x in (self.least, self.most))
        x = first + (last - first) * coordinates
        if self.scale == REFLECTANCE:
            x = np.exp(x) - DARK
        elif self.scale != LINEAR:
            x = x * x
        return np.clip(x, self.least, self.most)


def _scaled(scale: str, value: Any, xp: Any) -> Any:
    if scale == REFLECTANCE:
        return xp.log(value + DARK)
    return value if scale == LINEAR else xp.sqrt(value)


#: From values (k, d) along the axes to codes (C, k, L); C is 1 if the channels are the same there.
CodesAt = Callable[[np.ndarray], np.ndarray]


class Baked(NamedTuple):
    """Codes of a material at the nodes of its axes."""

    model: Model
    axes: tuple[Axis, ...]
    codes: np.ndarray  # float32 (C, N, L), the last axis the fastest; C as of `CodesAt`

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of nodes along each axis."""
        return (NODES[len(self.axes)],) * len(self.axes)

    def at(self, coordinates: np.ndarray, channel: int) -> np.ndarray:
        """Codes (k, L) of a channel at coordinates (k, d), without their lobes right in between."""
        codes, total = self.codes[min(channel, len(self.codes) - 1)], 0.0
        for node, weight in simplex(self.shape, coordinates):
            total = total + weight[:, None] * codes[node]
        return np.asarray(total, np.float32)


def simplex(shape: Sequence[int], coordinates: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Nodes (k,) and weights (k,) of the d + 1 corners of the simplex around coordinates (k, d).

    The cell is cut into the simplices along which coordinates ascend (Kuhn 1960).
    """
    counts = np.array(shape)
    place = np.clip(coordinates, 0, 1) * (counts - 1)
    first = np.minimum(place.astype(int), counts - 2)
    steps = np.cumprod([1, *counts[:0:-1]])[::-1]
    share = place - first
    order = np.argsort(-share, axis=1)
    share = np.take_along_axis(share, order, axis=1)
    ends = np.pad(share, [(0, 0), (1, 1)], constant_values=[(0, 0), (1, 0)])
    node = first @ steps
    found = [(node, ends[:, 0] - ends[:, 1])]
    for k in range(len(shape)):
        node = node + steps[order[:, k]]
        found.append((node, ends[:, k + 1] - ends[:, k + 2]))
    return found


def bake(model: Model, axes: Sequence[Axis], codes_at: CodesAt, lobes_at: Any) -> Baked:
    """The codes at the nodes of the axes, at most four.

    lobes_at: from values (k, d) to the lobes (k, N) of the codes.
    """
    own, count = tuple(axes), NODES[len(axes)]
    lobe = model.arch.lobe

    def values(x: np.ndarray) -> np.ndarray:
        return np.stack([a.values(column) for a, column in zip(own, x.T, strict=True)], axis=1)

    x = points(len(own), POINTS[len(own)])
    computed = codes_at(values(x))[..., lobe:]
    side = np.linspace(0, 1, count)
    nodes = np.stack(np.meshgrid(*[side] * len(own), indexing="ij"), -1).reshape(-1, len(own))
    tops, rest = lobes_at(values(nodes)), spline(x, np.moveaxis(computed, 0, 1))(nodes)
    codes = [np.concatenate([tops, part], 1, dtype=np.float32) for part in np.moveaxis(rest, 1, 0)]
    return Baked(model, own, np.stack([limit_albedo(model, part) for part in codes]))


def points(dimensions: int, count: int) -> np.ndarray:
    """Points (count, d) of the unit cube: its corners, and others that are denser near its ends."""
    corners = np.array(list(np.ndindex(*[2] * dimensions)), float)
    sequence = qmc.Sobol(dimensions, seed=0)
    others = sequence.random_base2((count - 1).bit_length())[: count - len(corners)]
    return np.concatenate([corners, 0.5 - 0.5 * np.cos(np.pi * others)])


def spline(x: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The function of points (n, d) that takes values (m, ...) at x (m, d).

    It is sums of cubed distances, and linear far away.
    """

    def parts(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distance2 = sum(np.square(a[:, None] - b) for a, b in zip(y.T, x.T, strict=True))
        return np.asarray(distance2) ** 1.5, np.concatenate([np.ones((len(y), 1)), y], axis=1)

    cubes, linear = parts(x)
    corner = np.zeros((linear.shape[1],) * 2)
    system = np.block([[cubes, linear], [linear.T, corner]])
    given = np.pad(values.reshape(len(x), -1).astype(np.float64), [(0, len(corner)), (0, 0)])
    weights = np.linalg.solve(system, given)

    def found(y: np.ndarray) -> np.ndarray:
        blocks = [y[start : start + 4096] for start in range(0, len(y), 4096)]
        rows = [np.concatenate(parts(block), axis=1) @ weights for block in blocks]
        return np.concatenate(rows).reshape(len(y), *values.shape[1:])

    return found
