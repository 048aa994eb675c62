"""Codes of a material at points of its axes, by light transport there."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from urushi.checks import CoatParameters
from urushi.nets import lobe as lobes
from urushi.nets import transmittance
from urushi.nets.weights import Model
from urushi.textures.axes import Axis, Changes
from urushi.textures.interpolation import points
from urushi.textures.own_functions import extended, own_functions

#: Points of transport by the number of axes, of one width and of two; a point of two widths takes
#: much longer.
POINTS = {1: (32, 128, 256, 384, 640, 768), 2: (24, 64, 112, 144, 176, 192)}

#: Most axes.
AXES = len(POINTS[1])

#: Slopes of constants change slowly along axes: they are computed at every fourth point.
SPARSE = 4

#: [1/sr] Added to g (`nets.transmittance`) in codes along axes, and subtracted again where they are
#: evaluated: the logarithm of a rest that becomes black would have no bound. A Lambertian surface
#: of `axes.DARK` under a coat has about as much, so that codes are linear in its coordinate.
FAINT = 1e-3


class Rows(Protocol):
    """A coated material at rows of values (k, d) along the axes, and then changes of constants.

    C is 1 if all channels are alike at the same values.
    """

    def coats(self, values: np.ndarray) -> CoatParameters:
        """The coats, arrays (C, k)."""

    def transported(self, values: np.ndarray) -> tuple[np.ndarray, float]:
        """f (C, k, P) [1/sr] at the probe pairs by light transport, without the lobes of coats; and
        the largest `Substrate.ceiling`."""

    def tables(self, values: np.ndarray, channels: np.ndarray) -> np.ndarray:
        """g (k, N) [1/sr] of `nets.transmittance` of channels (k,) at the nodes of `core.table`;
        materials of two widths have none."""


class Transported(NamedTuple):
    """Values of k points after each of n changes of constants."""

    values: np.ndarray  # (C, k, n, d) as of `Rows`, the same in all channels
    g: np.ndarray  # (C, k, n, P) [1/sr] at the probe pairs
    lobes: np.ndarray  # (1, k, n, M)
    passed: np.ndarray  # (C, k, n, P) T(wi) T(wo), the same in all channels


class PointCodes:
    """Codes at points, in the basis and functions of the material.

    Attributes:
        x: (k, d) coordinates of the points.
        functions: of the material, see `own_functions`.
        rests: float32 (C, k, K) of the codes, with `FAINT`.
        slopes: by each constant (C, k', K) of the rests at every `SPARSE` th point.
        ceiling: the largest albedo.
    """

    def __init__(
        self, model: Model, axes: Sequence[Axis], rows: Rows, constants: Mapping[str, Changes]
    ):
        self._model, self._axes, self._rows = model, axes, rows
        self._constants, self.ceiling = len(constants), 1.0
        count = len(axes)
        levels = [axis.levels for axis in axes]
        self.x = points(levels, POINTS[model.widths][count - 1]) if count else np.zeros((1, 0))
        parts, weights = [self._transported(self.x, np.zeros((1, self._constants)))], []
        for changes, unit in zip(constants.values(), np.eye(self._constants), strict=True):
            own = slope_weights(np.array([changes]), np.zeros(1))[0]
            used = np.flatnonzero(own)
            weights.append(own[used])
            ways = np.array(changes)[used, None] * unit
            parts.append(self._transported(self.x[::SPARSE], ways))
        rests = [encoded(model, part) for part in parts]
        self.functions = np.empty((len(model.networks.basis.rows), 0), np.float32)
        if model.widths == 1:
            self.functions = self._functions(parts, rests)
        if self.functions.size:
            own = extended(model, self.functions)
            rests = [encoded(own, part) for part in parts]
        self.rests = rests[0][:, :, 0]
        self.slopes = [
            np.einsum("n,cknj->ckj", *pair) for pair in zip(weights, rests[1:], strict=True)
        ]

    def lobes(self, x: np.ndarray) -> np.ndarray:
        """The lobes float32 (k, M) of the coats at coordinates (k, d)."""
        return self._lobes(self._values(x, np.zeros(self._constants)))[0]

    def _values(self, x: np.ndarray, changes: np.ndarray) -> np.ndarray:
        columns = [a.values(column) for a, column in zip(self._axes, x.T, strict=True)]
        columns += [np.full(len(x), change) for change in changes]
        return np.stack(columns, axis=1)

    def _lobes(self, values: np.ndarray) -> np.ndarray:
        alpha, eta, *_ = self._rows.coats(values)
        return np.asarray(lobes.of_coat(alpha, eta), np.float32)

    def _transported(self, x: np.ndarray, ways: np.ndarray) -> Transported:
        values = [self._values(x, way) for way in ways]
        found, ceilings = zip(*map(self._rows.transported, values), strict=True)
        f, self.ceiling = np.stack(found, axis=-2), max(self.ceiling, *ceilings)
        tops = np.stack([self._lobes(own)[:1] for own in values], axis=-2)
        passed = transmittance.both_ways(tops[..., None, :], *self._model.networks.pairs())
        own, shape = np.stack(values, axis=1), f.shape[:3]
        own = np.broadcast_to(own, (*shape, own.shape[-1]))
        return Transported(own, f / passed + FAINT, tops, np.broadcast_to(passed, f.shape))

    def _functions(self, parts: Sequence[Transported], rests: Sequence[np.ndarray]) -> np.ndarray:
        """The functions of the material; rests: of the parts' codes without them."""

        def flat(arrays: Iterable[np.ndarray]) -> np.ndarray:
            return np.concatenate([x.reshape(-1, x.shape[-1]) for x in arrays])

        values = flat(part.values for part in parts)
        sizes = [part.g.shape[:3] for part in parts]
        channels = np.concatenate([np.repeat(np.arange(c), k * n) for c, k, n in sizes])

        def tables(some: np.ndarray) -> np.ndarray:
            return self._rows.tables(values[some], channels[some]) + FAINT

        g, passed = flat(part.g for part in parts), flat(part.passed for part in parts)
        return own_functions(self._model, g, passed, flat(rests), tables)


def encoded(model: Model, part: Transported) -> np.ndarray:
    """Rests (C, k, n, K).

    Codes of a place have the same stretch, so that their differences are those of f: stretches are
    rounded.
    """
    return model.networks.encode_rest(part.g, part.lobes)[..., model.arch.lobe :]


def slope_weights(places: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Weights (k, 3) of values at places (k, 3): the slope at `at` (k,) of a quadratic.

    At the end of a range, where all places are on one side, it is as accurate as a difference of
    both sides is elsewhere.
    """
    others = places[:, [[1, 2], [0, 2], [0, 1]]]  # of each place, the two others
    sums = 2 * at[:, None] - others.sum(axis=-1)
    return sums / np.prod(places[:, :, None] - others, axis=-1)
