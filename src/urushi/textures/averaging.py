"""What the code of an average lacks once it is encoded, as a regression.

Two steps of Gauss and Newton bring an encoded average of unlike BRDFs five times closer to its
values (`correct`). Millions of texels have no time for them: a regression on some averages of a
texture tells what they would change.

Averages of BRDFs as codes: taken of their values, and encoded again.

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

from urushi.material import regression
from urushi.material.fit import correct_codes_serial
from urushi.material.regression import CodeFeatures
from urushi.nets.features import direction_features
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks, one_blas_thread

#: Damping of the steps: more than for what is encoded, as a regression cannot follow what small
#: changes of the values do to numbers of a code that they hardly determine.
CORRECTION_DAMPING = 1e-2

#: Of the regression: random features besides the numbers themselves, its ridge, and the least
#: spread of a number that means anything.
CORRECTION_FEATURES, CORRECTION_RIDGE, CORRECTION_LEAST_SPREAD = 128, 1e-3, 1e-4

#: What is closer than this share of the typical distance is hardly an average, and left alone; and
#: no change is divided by less when the regression is fitted.
NEAR_SHARE, LEAST_SHARE = 0.05, 0.05

#: Averages of codes are known to this, in units of their spread, squared.
ROUNDING = 1e-6


def corrected_averages(networks: UrushiNetworks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Codes (n, L) that decode to averages f (n, P) at the probe pairs, starting at z (n, L)."""
    return correct_codes_serial(networks, z, f, CORRECTION_DAMPING)[0]


class AverageCorrection(NamedTuple):
    """The same by a regression; where nothing was averaged, codes stay as they are.

    Attributes:
        features, coefficients: (F, L), of the change.
        scale: (L,) one over the spread of codes.
        near: where the change is halved: a squared distance between the encoded average and the
            average of codes, in units of the spread.
    """

    features: CodeFeatures
    coefficients: np.ndarray
    scale: np.ndarray
    near: float

    def __call__(self, z: np.ndarray, rest: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """Codes (n, L).

        z: (n, L) as encoded; rest: (n, L) the part of it that the encoder has not told; mean:
        (n, L) of the codes that were averaged.
        """
        change = self.features(_correction_inputs(z, rest)) @ self.coefficients
        change *= _correction_share(_distance(z, mean, self.scale), self.near)[:, None]
        return change + z


def fit_average_correction(
    z: np.ndarray, rest: np.ndarray, mean: np.ndarray, aim: np.ndarray
) -> AverageCorrection:
    """The regression from averages as for `Settling.__call__` and what `exact` makes of them.

    Its random features' seed is fixed.
    """
    spread = mean.std(axis=0)
    scale = 1 / (spread + 0.01 * spread.max() + CORRECTION_LEAST_SPREAD)
    distance = _distance(z, mean, scale)
    near = NEAR_SHARE * float(np.median(distance)) + ROUNDING
    share = np.maximum(_correction_share(distance, near), LEAST_SHARE)
    seen = _correction_inputs(z, rest)
    features = regression.fit_features(
        seen, CORRECTION_FEATURES, CORRECTION_LEAST_SPREAD, np.random.default_rng(0)
    )
    coefficients = regression.ridge_coefficients(
        features(seen), (aim - z) / share[:, None], CORRECTION_RIDGE, weights=share**2
    )
    return AverageCorrection(features, coefficients, scale, near)


def _correction_inputs(z: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """What the change depends on: not on the gain, the first number of a code."""
    return np.concatenate([z[:, 1:], rest], axis=1)


def _distance(z: np.ndarray, mean: np.ndarray, scale: np.ndarray) -> np.ndarray:
    return np.square((z - mean) * scale).mean(axis=1)


def _correction_share(distance: np.ndarray, near: float) -> np.ndarray:
    return distance / (distance + near)


#: Codes that the regression is fitted to; textures of no more are decoded as they are.
SAMPLE = 2048

#: Of the regression: random features besides the codes themselves, and its ridge.
FEATURES, RIDGE = 128, 1e-6

#: Probe pairs that tell the others; by averages of 2, 4, ... so many times two random codes.
KEPT_PAIRS, HALVINGS = 48, 4

#: Codes that are decoded at once, at all pairs; that tell the regression's error; and averages of
#: each halving that tell what the encoder lacks.
DECODED_BLOCK, ERROR_SAMPLE, CORRECTION_SAMPLE = 8, 256, 256

#: A code's numbers vary by more than this if they mean anything.
LEAST_SPREAD = 1e-4


class AveragingSpace(Protocol):
    """Where codes are averaged."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """What of codes (n, size) averages linearly, (n, K)."""

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The codes (n, size) of averages (n, K)."""


class LatentSpace:
    """Codes as they are, as in Fan et al. (2022): for the paper's networks."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """The codes."""
        return z

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Their averages."""
        return means


class DecodedSpace(NamedTuple):
    """Values at the probe pairs and the remainder, by decoding."""

    networks: UrushiNetworks

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, P), z - E(f), and z."""
        features = direction_features(*self.networks.pairs())
        f = np.concatenate([self.networks.decode(z[some, None], features) for some in _blocks(z)])
        return np.concatenate([f, z - self.networks.encode(f), z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, add the remainder, and settle."""
        f, rest, _ = self.parts(means)
        z = self.networks.encode(f) + rest
        parts = [corrected_averages(self.networks, z[some], f[some]) for some in _blocks(z)]
        return np.concatenate(parts)

    def parts(self, means: np.ndarray) -> list[np.ndarray]:
        """Values (n, P), remainders (n, size) and codes (n, size) of averages."""
        return _split_means(means, len(self.networks.pairs()[0]))


class RegressionSpace(NamedTuple):
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

    exact: DecodedSpace
    kept: np.ndarray
    encode: Callable[[np.ndarray], np.ndarray]
    settle: AverageCorrection
    features: CodeFeatures
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
        f, rest, mean = _split_means(means, len(self.kept))
        return self.settle(self.encode(f) + rest, rest, mean)

    def fits(self, z: np.ndarray) -> bool:
        """Whether codes (n, size) are told about as well as the sample was."""
        return self.distance(z) <= 2 * self.error + 0.01

    def distance(self, z: np.ndarray) -> float:
        """Root mean square of ln f between codes (n, size) and what comes back of them."""
        lifted = (self.exact.lift(codes) for codes in (z, self.drop(self.lift(z))))
        f, again = (self.exact.parts(rows)[0] for rows in lifted)
        return float(np.sqrt(np.square(np.log(again / f)).mean()))


def averaging_space(
    model: Model, read: Callable[[np.ndarray], np.ndarray], count: int
) -> AveragingSpace:
    """The space for a texture's codes; read: codes (n, size) by their indices below `count`.

    The sample's seed is fixed.
    """
    networks = model.networks
    if not isinstance(networks, UrushiNetworks):
        return LatentSpace()
    exact = DecodedSpace(networks)
    if count <= SAMPLE:
        return exact
    rng = np.random.default_rng(0)
    z = read(rng.integers(count, size=SAMPLE)).astype(np.float32)
    known = np.empty((len(z), len(networks.pairs()[0]) + 2 * z.shape[1]), np.float32)
    fill_blocks(known, exact.lift, z, rows=DECODED_BLOCK)
    mixed = [known]
    for _ in range(HALVINGS):
        mixed.append(0.5 * (mixed[-1] + rng.permutation(mixed[-1])))
    with one_blas_thread():
        kept, encode = _reduced_encoder(
            networks, np.concatenate([exact.parts(part)[0] for part in mixed])
        )
        f, rest, _ = exact.parts(known)
        features, coefficients = _fit_regression(z, f, rest, kept, rng)
    settle = _fit_correction(
        exact, kept, encode, np.concatenate([part[:CORRECTION_SAMPLE] for part in mixed[1:]])
    )
    made = RegressionSpace(exact, kept, encode, settle, features, coefficients, 0.0)
    with one_blas_thread():
        return made._replace(error=made.distance(z[:ERROR_SAMPLE]))


def _fit_regression(
    z: np.ndarray, f: np.ndarray, rest: np.ndarray, kept: np.ndarray, rng: np.random.Generator
) -> tuple[CodeFeatures, np.ndarray]:
    """Features and coefficients of `Estimated`, from codes (n, size) that were lifted exactly."""
    features = regression.fit_features(z, FEATURES, LEAST_SPREAD, rng)
    target = np.concatenate([np.log(f[:, kept]) - z[:, :1], rest], axis=1)
    return features, regression.ridge_coefficients(features(z), target, RIDGE)


def _fit_correction(
    exact: DecodedSpace,
    kept: np.ndarray,
    encode: Callable[[np.ndarray], np.ndarray],
    means: np.ndarray,
) -> AverageCorrection:
    """What the codes of averages (n, P + 2 size) lack, once they are encoded by some pairs."""
    f, rest, mean = exact.parts(means)
    start = encode(f[:, kept]) + rest
    aim = np.empty_like(start)
    fill_blocks(aim, partial(corrected_averages, exact.networks), start, f, rows=DECODED_BLOCK)
    with one_blas_thread():
        return fit_average_correction(start, rest, mean, aim)


def _blocks(rows: np.ndarray) -> list[slice]:
    """Cuts rows into blocks that fit a core's cache once they are decoded."""
    return [slice(start, start + DECODED_BLOCK) for start in range(0, len(rows), DECODED_BLOCK)]


def _split_means(rows: np.ndarray, pairs: int) -> list[np.ndarray]:
    """Cut rows (n, pairs + 2 size)."""
    return np.split(rows, [pairs, (pairs + rows.shape[1]) // 2], axis=1)


def _reduced_encoder(
    networks: UrushiNetworks, f: np.ndarray
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Which pairs (K,) tell what the encoder sees of f (n, P), and how it encodes them.

    The pairs are those of a pivoted Cholesky factorisation: each is the one of which those before
    it tell least.
    """
    seen = networks.normalised(f).astype(np.float64)
    mean = seen.mean(axis=0)
    covariance = np.cov(seen, rowvar=False) + RIDGE * np.eye(len(mean))
    left, kept = covariance.copy(), []
    for _ in range(min(KEPT_PAIRS, len(mean))):
        kept.append(int(left.diagonal().argmax()))
        left -= np.outer(left[:, kept[-1]], left[kept[-1]]) / left[kept[-1], kept[-1]]
    matrix = np.linalg.solve(covariance[np.ix_(kept, kept)], covariance[kept])
    offset = mean - mean[kept] @ matrix
    few = np.array(kept)
    return few, networks.reduced_encoder(few, matrix.astype(np.float32), offset.astype(np.float32))
