"""Principal numbers: the codes of one material by fewer numbers, for rendering.

The codes of a material that varies differ less than those of all materials. With c the numbers of a
code after its gain, c = mean + d A, where d are the principal components of the material's codes in
the metric of the error of ln f. The gain is kept apart and is exact. A renderer then looks up the
few functions U A of the material in place of all functions U, and reads fewer bytes.

With two widths, functions of the same factor of the azimuth (`core.stretched`) have components of
their own. The mean is that of the functions without a factor. The stretch stays as it is.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from urushi.core.stretched import rounded
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model

#: Numbers of functions that are tried. With the mean they fill packets.
COUNTS = 3, 7, 11, 15, 23, 31

#: Errors of f at the probe pairs: their mean over a material, and the largest one.
MEAN_ERROR, LARGEST_ERROR = 1.5e-3, 2e-2

#: Codes by which the errors are measured, evenly spaced, and those that are represented worst.
SAMPLE, WORST = 256, 64

#: Codes that are projected at once: bounds memory.
BLOCK = 1 << 17

#: Share of the measure beside the light in the metric.
FLOOR = 0.02


@dataclass
class Projection:
    """Rests c of codes as principal numbers: a gain, components d, and of two widths ln s."""

    mean: np.ndarray  # (K - 1,) of the numbers after the gain
    into: np.ndarray  # (K - 1, N)
    back: np.ndarray  # (N, K - 1)
    levels: np.ndarray  # (K - 1,) mean over the light of each function without a factor
    factors: np.ndarray  # (N,) of the components, see `nets.basis.Basis`

    def numbers(self, rests: np.ndarray) -> np.ndarray:
        """Principal numbers (..., 1 + N) of rests (..., K); of two widths one more of both."""
        center = np.zeros(rests.shape[-1])
        center[1 : 1 + len(self.mean)] = self.mean
        return self.changes(rests - center)

    def rests(self, numbers: np.ndarray) -> np.ndarray:
        """Rests (..., K) of principal numbers (..., 1 + N); of two widths one more of both."""
        gain, d, stretch = np.split(numbers, [1, 1 + len(self.back)], axis=-1)
        off = d @ self.back
        gain = gain - (off @ self.levels)[..., None]
        return np.concatenate([gain, off + self.mean, stretch], axis=-1)

    def changes(self, slopes: np.ndarray) -> np.ndarray:
        """Slopes of `numbers` for slopes of rests."""
        gain, c, stretch = np.split(slopes, [1, 1 + len(self.mean)], axis=-1)
        gain = gain + (c @ self.levels)[..., None]
        return np.concatenate([gain, c @ self.into, stretch], axis=-1)

    def functions(self, rows: np.ndarray) -> np.ndarray:
        """Mean and functions (P, 1 + N) of principal numbers, from rows (P, 1 + K) of a basis."""
        others = rows[:, 2:]
        mean = rows[:, :1] + (others @ self.mean)[:, None]
        return np.concatenate([mean, (others - self.levels) @ self.back.T], axis=1)

    def first(self, count: int) -> "Projection":
        """The projection to the first components."""
        into, back, factors = self.into[:, :count], self.back[:count], self.factors[:count]
        return replace(self, into=into, back=back, factors=factors)


def projection_of(
    model: Model, tops: np.ndarray, rests: np.ndarray
) -> tuple[np.ndarray, Projection]:
    """The projection of codes, and its mean and functions float32 (P, 1 + N) at the table's nodes.

    Components are scaled to functions of which the largest value is one.

    tops: lobes (C, N, M), C may be one. rests: (C, N, K), of two widths (C, N, K + 1).
    """
    tops = np.broadcast_to(tops, (*rests.shape[:2], tops.shape[-1])).reshape(-1, tops.shape[-1])
    rests = rests.reshape(-1, rests.shape[-1])
    some = np.arange(0, len(rests), -(-len(rests) // SAMPLE))
    whole = _projection(model, tops[some], rests[some], rests)
    first, last = 1 + COUNTS[-1], 1 + len(whole.back)
    left = [np.square(whole.numbers(x)[:, first:last]).sum(axis=-1) for x in _blocks(rests)]
    worst = np.argpartition(np.concatenate(left), -min(WORST, len(rests)))[-WORST:]
    tried = np.append(some, worst)
    projection = _sufficient(model, whole, tops[tried], rests[tried], len(some))
    functions = projection.functions(model.networks.basis.rows)
    size = np.maximum(np.abs(functions[:, 1:]).max(axis=0), 1e-9)
    functions[:, 1:] /= size
    into, back = projection.into * size, projection.back / size[:, None]
    return functions.astype(np.float32), replace(projection, into=into, back=back)


def _blocks(rests: np.ndarray) -> Iterator[np.ndarray]:
    return (rests[start : start + BLOCK] for start in range(0, len(rests), BLOCK))


def _projection(model: Model, tops: np.ndarray, some: np.ndarray, rests: np.ndarray) -> Projection:
    """The projection of rests (n, K) to all components, the most important first.

    tops, some: lobes (S, M) and rests (S, K) of a sample.
    """
    own = model.networks.basis
    stretch = float(rounded(own.split(some)[1].mean()))
    rows, factors = own.probe_rows(stretch).astype(np.float64), own.factors[2:]
    rest = _rests(model, tops, some).astype(np.float64)
    light = (rest + lobes.f(tops[:, None], *own.pairs())) @ own.measure
    share = (rest / np.maximum(light, 1e-12)[:, None]).mean(axis=0)
    weights = own.measure * (share + FLOOR)
    weights /= weights.sum()
    plain = factors == 0
    levels = np.where(plain, weights @ rows[:, 2:], 0)
    others = rows[:, 2:] - levels
    metric = (others * weights[:, None]).T @ others
    metric += 1e-9 * np.trace(metric) * np.eye(len(metric))
    total, squares = np.zeros(len(metric)), np.zeros_like(metric)
    for part in _blocks(rests):
        c = part[:, 1 : own.size].astype(np.float64)
        total, squares = total + c.sum(axis=0), squares + c.T @ c
    mean = np.where(plain, total / len(rests), 0)
    spread = squares / len(rests) - np.outer(mean, mean)
    into, sizes = np.zeros_like(metric), np.zeros(len(metric))
    for factor in np.unique(factors):
        at = np.flatnonzero(factors == factor)
        root = np.linalg.cholesky(metric[np.ix_(at, at)])
        sizes[at], axes = np.linalg.eigh(root.T @ spread[np.ix_(at, at)] @ root)
        into[np.ix_(at, at)] = root @ axes
    order = np.argsort(-sizes)
    return Projection(mean, into[:, order], np.linalg.inv(into)[order], levels, factors[order])


def _sufficient(
    model: Model, whole: Projection, tops: np.ndarray, rests: np.ndarray, count: int
) -> Projection:
    """The projection to so few components that codes stay, `count` typical ones first."""
    for projection in map(whole.first, COUNTS):
        errors = _errors(model, tops, rests, projection)
        if errors[:count].mean() < MEAN_ERROR and errors.max() < LARGEST_ERROR:
            return projection
    return whole


def _errors(
    model: Model, tops: np.ndarray, rests: np.ndarray, projection: Projection
) -> np.ndarray:
    """Errors E (n,) of f at the probe pairs by a projection; codes: lobes (n, M), rests (n, K)."""
    own = model.networks.basis
    f, found = (
        _rests(model, tops, x) for x in (rests, projection.rests(projection.numbers(rests)))
    )
    light = f + lobes.f(tops[:, None], *own.pairs())
    return (np.abs(found - f) @ own.measure) / np.maximum(light @ own.measure, 1e-12)


def _rests(model: Model, tops: np.ndarray, rests: np.ndarray) -> np.ndarray:
    """f without lobes (n, P) [1/sr] at the probe pairs, of codes: lobes (n, M), rests (n, K)."""
    codes = np.concatenate([tops, rests], axis=1, dtype=np.float32)
    if model.widths == 2:
        codes[:, -1] = rounded(codes[:, -1])
    return model.networks.rest_at_all(codes, model.networks.basis.probe_rows)
