"""Averages of BRDFs as codes: taken of their values, and encoded again.

BRDFs do not average as their codes do. Their values at the encoder's probe pairs do: the average of
codes z is E(mean D(z)), with D the values that a code decodes to and E the encoder. E(D(z)) is not
quite z, so that the mean of z - E(D(z)) is added: what is the same everywhere keeps its code.

Decoding millions of codes at all pairs would take hours; but the codes of a texture lie close
together. A regression on some of them gives ln D(z) and the remainder, at few of the pairs, which
tell the encoder all others.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from urushi.material import regression
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

#: Codes that are decoded at once, at all pairs, and that tell the regression's error.
DECODED, JUDGED = 8, 256

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
        """f (n, P) and z - E(f)."""
        features = direction_features(*self.networks.pairs())
        some = (z[start : start + DECODED, None] for start in range(0, len(z), DECODED))
        f = np.concatenate([self.networks.decode(codes, features) for codes in some])
        return np.concatenate([f, z - self.networks.encode(f)], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, and add the remainder."""
        pairs = len(self.networks.pairs()[0])
        return self.networks.encode(means[:, :pairs]) + means[:, pairs:]


class Estimated(NamedTuple):
    """The same, by a regression.

    Attributes:
        exact: what it stands for.
        kept: (K,) the probe pairs that tell the others.
        encode: makes codes of values at these.
        features, coefficients: (F, K + size); the first numbers tell ln f less the gain, the others
            the remainder.
        error: root mean square of ln f, of codes that were lifted and dropped.
    """

    exact: Decoded
    kept: np.ndarray
    encode: Callable[[np.ndarray], np.ndarray]
    features: Features
    coefficients: np.ndarray
    error: float

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, K) and z - E(f), about."""
        result = self.features(z) @ self.coefficients
        logs = result[:, : len(self.kept)]
        logs += z[:, :1]
        np.exp(logs, out=logs)
        return result

    def drop(self, means: np.ndarray) -> np.ndarray:
        """As of `Decoded`."""
        pairs = len(self.kept)
        return self.encode(means[:, :pairs]) + means[:, pairs:]

    def fits(self, z: np.ndarray) -> bool:
        """Whether codes (n, size) are told about as well as the sample was."""
        return self.distance(z) <= 2 * self.error + 0.01

    def distance(self, z: np.ndarray) -> float:
        """Root mean square of ln f between codes (n, size) and what comes back of them."""
        f, again = (self.exact.lift(codes) for codes in (z, self.drop(self.lift(z))))
        pairs = f.shape[1] - z.shape[1]
        return float(np.sqrt(np.square(np.log(again[:, :pairs] / f[:, :pairs])).mean()))


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
    pairs = len(networks.pairs()[0])
    known = np.empty((len(z), pairs + z.shape[1]), np.float32)
    fill(known, exact.lift, z, rows=DECODED)
    with one_thread():
        f, rest = known[:, :pairs], known[:, pairs:]
        kept, encode = _fewer(networks, f, rng)
        features = regression.features(z, FEATURES, LEAST_SPREAD, rng)
        target = np.concatenate([np.log(f[:, kept]) - z[:, :1], rest], axis=1)
        coefficients = regression.coefficients(features(z), target, RIDGE)
        made = Estimated(exact, kept, encode, features, coefficients, 0.0)
        return made._replace(error=made.distance(z[:JUDGED]))


def _fewer(
    networks: OnePass, f: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Which pairs (K,) tell what the encoder sees of averages of f (n, P), and how it encodes them.

    The pairs are those of a pivoted Cholesky factorisation: each is the one of which those before
    it tell least.
    """
    averages = [f]
    for _ in range(HALVINGS):
        averages.append(0.5 * (averages[-1] + rng.permutation(averages[-1])))
    seen = networks.normalised(np.concatenate(averages)).astype(np.float64)
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
