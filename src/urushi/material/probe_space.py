"""Averages of BRDFs as codes: taken of their values, and encoded again.

BRDFs do not average as their codes do. Their values at the encoder's probe pairs do: the average of
codes z is E(mean D(z)), with D the values that a code decodes to and E the encoder. E(D(z)) is not
quite z, so that the mean of z - E(D(z)) is added: what is the same everywhere keeps its code.

Decoding millions of codes at all pairs would take hours; but the codes of a texture lie close
together. A regression on some of them gives ln D(z), of low rank, and the remainder.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from urushi.material import regression
from urushi.material.cores import fill
from urushi.material.regression import Features
from urushi.nets.networks import OnePass
from urushi.nets.weights import Model

#: Codes that the regression is fitted to; textures of no more are decoded as they are.
SAMPLE = 2048

#: Numbers by which ln f at the pairs is told; the regression's random features besides the codes
#: themselves, and its ridge.
RANK, FEATURES, RIDGE = 24, 128, 1e-6

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
        f = self.networks.f(z[:, None], *self.networks.pairs())
        return np.concatenate([f, z - self.networks.encode(f)], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, and add the remainder."""
        pairs = len(self.networks.pairs()[0])
        return self.networks.encode(means[:, :pairs]) + means[:, pairs:]


class Estimated(NamedTuple):
    """The same, by a regression.

    Attributes:
        exact: what it stands for.
        features, coefficients: (F, RANK + size); the first numbers tell ln f, less the gain,
        mean, basis: (P,), (RANK, P); the others are the remainder.
        error: root mean square of ln f in the sample.
    """

    exact: Decoded
    features: Features
    coefficients: np.ndarray
    mean: np.ndarray
    basis: np.ndarray
    error: float

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, P) and z - E(f), about."""
        told = self.features(z) @ self.coefficients
        rank, pairs = self.basis.shape
        result = np.empty((len(z), pairs + z.shape[1]), np.float32)
        logs = result[:, :pairs]
        np.matmul(told[:, :rank], self.basis, out=logs)
        logs += self.mean + z[:, :1]
        np.exp(logs, out=logs)
        result[:, pairs:] = told[:, rank:]
        return result

    def drop(self, means: np.ndarray) -> np.ndarray:
        """As of `Decoded`."""
        return self.exact.drop(means)

    def fits(self, z: np.ndarray) -> bool:
        """Whether codes (n, size) are told about as well as the sample was."""
        pairs = len(self.mean)
        logs = np.log(self.lift(z)[:, :pairs] / self.exact.lift(z)[:, :pairs])
        return bool(np.sqrt(np.square(logs).mean()) <= 2 * self.error + 0.01)


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
    fill(known, exact.lift, z)
    logs = np.log(known[:, :pairs]).astype(np.float64) - z[:, :1]
    mean = logs.mean(axis=0)
    basis = np.linalg.svd(logs - mean, full_matrices=False)[2][:RANK]
    features = regression.features(z, FEATURES, LEAST_SPREAD, rng)
    x, target = features(z), np.concatenate([(logs - mean) @ basis.T, known[:, pairs:]], axis=1)
    coefficients = regression.coefficients(x, target, RIDGE)
    error = (x @ coefficients[:, :RANK]) @ basis + mean - logs
    return Estimated(
        exact,
        features,
        coefficients,
        mean.astype(np.float32),
        basis.astype(np.float32),
        float(np.sqrt(np.square(error).mean())),
    )
