"""Principal numbers: the codes of one material by fewer numbers, for rendering.

The codes of a material that varies differ less than those of all materials. With c the numbers of a
code after its gain, c = mean + d A, where d are the principal components of the material's codes in
the metric of the error of ln f. The gain is kept apart and is exact. A renderer then looks up the
few functions U A of the material in place of all functions U, and reads fewer bytes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from urushi.nets import basis, transmittance
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.weights import Model

#: Numbers of functions that are tried. With the mean they fill packets.
COUNTS = 3, 7, 11, 15, 23

#: Errors of f at the probe pairs: their mean over a material, and the largest one.
MEAN_ERROR, LARGEST_ERROR = 2e-3, 2e-2

#: Codes by which the errors are measured, evenly spaced, and those that are represented worst.
SAMPLE, WORST = 256, 64

#: Codes that are projected at once: bounds memory.
BLOCK = 1 << 17

#: Share of the measure beside the light in the metric.
FLOOR = 0.02


@dataclass
class Projection:
    """Rests c of codes as principal numbers (..., 1 + N): a gain, and components d."""

    mean: np.ndarray  # (K - 1,) of the numbers after the gain
    into: np.ndarray  # (K - 1, N)
    back: np.ndarray  # (N, K - 1)
    levels: np.ndarray  # (K - 1,) mean of each function over the light

    def numbers(self, rests: np.ndarray) -> np.ndarray:
        """Principal numbers (..., 1 + N) of rests (..., K)."""
        return self.changes(rests - np.append(0, self.mean))

    def rests(self, numbers: np.ndarray) -> np.ndarray:
        """Rests (..., K) of principal numbers (..., 1 + N)."""
        off = numbers[..., 1:] @ self.back
        gain = numbers[..., :1] - (off @ self.levels)[..., None]
        return np.concatenate([gain, off + self.mean], axis=-1)

    def changes(self, slopes: np.ndarray) -> np.ndarray:
        """Slopes (..., 1 + N) of `numbers` for slopes (..., K) of rests."""
        gain = slopes[..., :1] + (slopes[..., 1:] @ self.levels)[..., None]
        return np.concatenate([gain, slopes[..., 1:] @ self.into], axis=-1)

    def functions(self, rows: np.ndarray) -> np.ndarray:
        """Mean and functions (P, 1 + N) of principal numbers, from rows (P, 1 + K) of a basis."""
        others = rows[:, 2:]
        mean = rows[:, :1] + (others @ self.mean)[:, None]
        return np.concatenate([mean, (others - self.levels) @ self.back.T], axis=1)

    def first(self, count: int) -> "Projection":
        """The projection to the first components."""
        return replace(self, into=self.into[:, :count], back=self.back[:count])


def projection_of(
    model: Model, tops: np.ndarray, rests: np.ndarray
) -> tuple[np.ndarray, Projection]:
    """The projection of codes, and its mean and functions float32 (P, 1 + N) at the table's nodes.

    Components are scaled to functions of which the largest value is one.

    tops: lobes (C, N, M), C may be one. rests: (C, N, K).
    """
    own = model.networks.basis
    tops = np.broadcast_to(tops, (*rests.shape[:2], tops.shape[-1])).reshape(-1, tops.shape[-1])
    rests = rests.reshape(-1, rests.shape[-1])
    some = np.arange(0, len(rests), -(-len(rests) // SAMPLE))
    whole = _projection(own, tops[some], rests[some], rests)
    left = [np.square(whole.numbers(x)[:, 1 + COUNTS[-1] :]).sum(axis=-1) for x in _blocks(rests)]
    worst = np.argpartition(np.concatenate(left), -min(WORST, len(rests)))[-WORST:]
    tried = np.append(some, worst)
    projection = _sufficient(own, whole, tops[tried], rests[tried], len(some))
    functions = projection.functions(own.rows)
    size = np.maximum(np.abs(functions[:, 1:]).max(axis=0), 1e-9)
    functions[:, 1:] /= size
    into, back = projection.into * size, projection.back / size[:, None]
    return functions.astype(np.float32), replace(projection, into=into, back=back)


def _blocks(rests: np.ndarray) -> Iterator[np.ndarray]:
    return (rests[start : start + BLOCK] for start in range(0, len(rests), BLOCK))


def _projection(own: Basis, tops: np.ndarray, some: np.ndarray, rests: np.ndarray) -> Projection:
    """The projection of rests (n, K) to all components, the most important first.

    tops, some: lobes (S, M) and rests (S, K) of a sample.
    """
    rows = own.probe_rows(0.0).astype(np.float64)
    rest = _rests(own, tops, some).astype(np.float64)
    light = (rest + lobes.f(tops[:, None], *own.pairs())) @ own.measure
    share = (rest / np.maximum(light, 1e-12)[:, None]).mean(axis=0)
    weights = own.measure * (share + FLOOR)
    weights /= weights.sum()
    levels = weights @ rows[:, 2:]
    others = rows[:, 2:] - levels
    metric = (others * weights[:, None]).T @ others
    metric += 1e-9 * np.trace(metric) * np.eye(len(metric))
    total, squares = np.zeros(len(metric)), np.zeros_like(metric)
    for part in _blocks(rests):
        c = part[:, 1:].astype(np.float64)
        total, squares = total + c.sum(axis=0), squares + c.T @ c
    mean = total / len(rests)
    root = np.linalg.cholesky(metric)
    spread = root.T @ (squares / len(rests) - np.outer(mean, mean)) @ root
    turned = root @ np.linalg.eigh(spread)[1][:, ::-1]
    return Projection(mean, turned, np.linalg.inv(turned), levels)


def _sufficient(
    own: Basis, whole: Projection, tops: np.ndarray, rests: np.ndarray, count: int
) -> Projection:
    """The projection to so few components that codes stay, `count` typical ones first."""
    for projection in map(whole.first, COUNTS):
        errors = _errors(own, tops, rests, projection)
        if errors[:count].mean() < MEAN_ERROR and errors.max() < LARGEST_ERROR:
            return projection
    return whole


def _errors(own: Basis, tops: np.ndarray, rests: np.ndarray, projection: Projection) -> np.ndarray:
    """Errors E (n,) of f at the probe pairs by a projection; codes: lobes (n, M), rests (n, K)."""
    f, found = (_rests(own, tops, x) for x in (rests, projection.rests(projection.numbers(rests))))
    light = f + lobes.f(tops[:, None], *own.pairs())
    return (np.abs(found - f) @ own.measure) / np.maximum(light @ own.measure, 1e-12)


def _rests(own: Basis, tops: np.ndarray, rests: np.ndarray) -> np.ndarray:
    """f without lobes (n, P) [1/sr] at the probe pairs, of codes: lobes (n, M), rests (n, K)."""
    g = basis.decode(rests[:, None], own.probe_rows(0.0))
    return g * transmittance.both_ways(tops[:, None], *own.pairs())
