"""Averages of BRDFs as codes: taken of their values, and encoded again.

BRDFs do not average as their codes do. Their values at the encoder's probe pairs do: the average of
codes z is E(mean D(z)), with D the values that a code decodes to and E the encoder. E(D(z)) is not
quite z, so that the mean of z - E(D(z)) is added: what is the same everywhere keeps its code. What
still lacks, `averages` adds.

Decoding millions of codes at all pairs would take hours; but the codes of a texture lie close
together. A regression on some of them gives ln D(z) and the remainder, at few of the pairs, which
tell the encoder all others.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from urushi.material import averages, regression
from urushi.material.averages import Settling
from urushi.material.cores import fill, one_thread
from urushi.material.regression import Features
from urushi.nets.features import direction_features
from urushi.nets.networks import OnePass
from urushi.nets.weights import Model

#: Codes that the regression is fitted to; textures of no more are decoded as they are.
SAMPLE = 2048

#: Of the regression: random features besides the codes themselves, and its ridge.
FEATURES, RIDGE = 128, 1e-6

#: Probe pairs that tell the others; by averages of 2, 4, ... so many times two random codes.
KEPT, HALVINGS = 48, 4

#: Codes that are decoded at once, at all pairs; that tell the regression's error; and averages of
#: each halving that tell what the encoder lacks.
DECODED, JUDGED, SETTLED = 8, 256, 256

#: A code's numbers vary by more than this if they mean anything.
LEAST_SPREAD = 1e-4


class Space(Protocol):
    """Where codes are averaged."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """What of codes (n, size) averages linearly, (n, K)."""

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The codes (n, size) of averages (n, K)."""


class Codes:
    """Codes as they are, as in Fan et al. (2022): for the paper's networks."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """The codes."""
        return z

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Their averages."""
        return means


class Decoded(NamedTuple):
    """Values at the probe pairs and the remainder, by decoding."""

    networks: OnePass

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, P), z - E(f), and z."""
        features = direction_features(*self.networks.pairs())
        f = np.concatenate([self.networks.decode(z[some, None], features) for some in _few(z)])
        return np.concatenate([f, z - self.networks.encode(f), z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, add the remainder, and settle."""
        f, rest, _ = self.parts(means)
        z = self.networks.encode(f) + rest
        parts = [averages.exact(self.networks, z[some], f[some]) for some in _few(z)]
        return np.concatenate(parts)

    def parts(self, means: np.ndarray) -> list[np.ndarray]:
        """Values (n, P), remainders (n, size) and codes (n, size) of averages."""
        return _parts(means, len(self.networks.pairs()[0]))


class Estimated(NamedTuple):
    """The same, by a regression.

    Attributes:
        exact: what it stands for.
        kept: (K,) the probe pairs that tell the others.
        encode: makes codes of values at these.
        settle: adds what these lack.
        features, coefficients: (F, K + size); the first numbers tell ln f less the gain, the others
            the remainder.
        error: root mean square of ln f, of codes that were lifted and dropped.
    """

    exact: Decoded
    kept: np.ndarray
    encode: Callable[[np.ndarray], np.ndarray]
    settle: Settling
    features: Features
    coefficients: np.ndarray
    error: float

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, K) and z - E(f), about; and z."""
        told = self.features(z) @ self.coefficients
        logs = told[:, : len(self.kept)]
        logs += z[:, :1]
        np.exp(logs, out=logs)
        return np.concatenate([told, z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """As of `Decoded`."""
        f, rest, mean = _parts(means, len(self.kept))
        return self.settle(self.encode(f) + rest, rest, mean)

    def fits(self, z: np.ndarray) -> bool:
        """Whether codes (n, size) are told about as well as the sample was."""
        return self.distance(z) <= 2 * self.error + 0.01

    def distance(self, z: np.ndarray) -> float:
        """Root mean square of ln f between codes (n, size) and what comes back of them."""
        lifted = (self.exact.lift(codes) for codes in (z, self.drop(self.lift(z))))
        f, again = (self.exact.parts(rows)[0] for rows in lifted)
        return float(np.sqrt(np.square(np.log(again / f)).mean()))


def of(model: Model, read: Callable[[np.ndarray], np.ndarray], count: int) -> Space:
    """The space for a texture's codes; read: codes (n, size) by their indices below `count`.

    The sample's seed is fixed.
    """
    networks = model.networks.one_pass
    if networks is None:
        return Codes()
    exact = Decoded(networks)
    if count <= SAMPLE:
        return exact
    rng = np.random.default_rng(0)
    z = read(rng.integers(count, size=SAMPLE)).astype(np.float32)
    known = np.empty((len(z), len(networks.pairs()[0]) + 2 * z.shape[1]), np.float32)
    fill(known, exact.lift, z, rows=DECODED)
    mixed = [known]
    for _ in range(HALVINGS):
        mixed.append(0.5 * (mixed[-1] + rng.permutation(mixed[-1])))
    with one_thread():
        kept, encode = _fewer(networks, np.concatenate([exact.parts(part)[0] for part in mixed]))
        f, rest, _ = exact.parts(known)
        features, coefficients = _told(z, f, rest, kept, rng)
    settle = _settling(exact, kept, encode, np.concatenate([part[:SETTLED] for part in mixed[1:]]))
    made = Estimated(exact, kept, encode, settle, features, coefficients, 0.0)
    with one_thread():
        return made._replace(error=made.distance(z[:JUDGED]))


def _told(
    z: np.ndarray, f: np.ndarray, rest: np.ndarray, kept: np.ndarray, rng: np.random.Generator
) -> tuple[Features, np.ndarray]:
    """Features and coefficients of `Estimated`, from codes (n, size) that were lifted exactly."""
    features = regression.features(z, FEATURES, LEAST_SPREAD, rng)
    target = np.concatenate([np.log(f[:, kept]) - z[:, :1], rest], axis=1)
    return features, regression.coefficients(features(z), target, RIDGE)


def _settling(
    exact: Decoded, kept: np.ndarray, encode: Callable[[np.ndarray], np.ndarray], means: np.ndarray
) -> Settling:
    """What the codes of averages (n, P + 2 size) lack, once they are encoded by some pairs."""
    f, rest, mean = exact.parts(means)
    start = encode(f[:, kept]) + rest
    aim = np.empty_like(start)
    fill(aim, partial(averages.exact, exact.networks), start, f, rows=DECODED)
    with one_thread():
        return averages.settling(start, rest, mean, aim)


def _few(rows: np.ndarray) -> list[slice]:
    """Cuts rows into blocks that fit a core's cache once they are decoded."""
    return [slice(start, start + DECODED) for start in range(0, len(rows), DECODED)]


def _parts(rows: np.ndarray, pairs: int) -> list[np.ndarray]:
    """Cut rows (n, pairs + 2 size)."""
    return np.split(rows, [pairs, (pairs + rows.shape[1]) // 2], axis=1)


def _fewer(
    networks: OnePass, f: np.ndarray
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Which pairs (K,) tell what the encoder sees of f (n, P), and how it encodes them.

    The pairs are those of a pivoted Cholesky factorisation: each is the one of which those before
    it tell least.
    """
    seen = networks.normalised(f).astype(np.float64)
    mean = seen.mean(axis=0)
    covariance = np.cov(seen, rowvar=False) + RIDGE * np.eye(len(mean))
    left, kept = covariance.copy(), []
    for _ in range(min(KEPT, len(mean))):
        kept.append(int(left.diagonal().argmax()))
        left -= np.outer(left[:, kept[-1]], left[kept[-1]]) / left[kept[-1], kept[-1]]
    matrix = np.linalg.solve(covariance[np.ix_(kept, kept)], covariance[kept])
    offset = mean - mean[kept] @ matrix
    few = np.array(kept)
    return few, networks.of_fewer(few, matrix.astype(np.float32), offset.astype(np.float32))
