"""Averages of BRDFs as latent codes, for the levels of a mip pyramid.

BRDFs do not average as their codes do, but their values at the encoder's probe pairs do. The
average of codes z is E(mean D(z)), where D decodes to values at the probe pairs and E encodes.
E(D(z)) differs a little from z, so the mean of the remainder z - E(D(z)) is added, and a constant
texture keeps its code. Two damped steps of Gauss and Newton (`material.fit`) then bring the code
five times closer to the averaged values.

To decode millions of codes at all pairs would take hours, but the codes of a texture lie close
together. Three regressions, fitted to a sample of them, replace the exact operations: ln D(z) and
the remainder at a few of the pairs, an encoder of these pairs, and the change by the two steps.
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

#: Damping of the steps, relative to the mean curvature. It is greater than in `material.fit`,
#: because a regression cannot follow numbers of a code that the values hardly determine.
CORRECTION_DAMPING = 1e-2

#: Regression of the change by the steps: number of random features, ridge, and least spread of a
#: number that is not constant.
CORRECTION_FEATURES, CORRECTION_RIDGE, CORRECTION_LEAST_SPREAD = 128, 1e-3, 1e-4

#: Share of the median distance below which a code is hardly an average and changes by less than
#: half of the regression's value; and the least share by which a target is divided.
NEAR_SHARE, LEAST_SHARE = 0.05, 0.05

#: Rounding error of averages of codes, in units of their spread, squared.
ROUNDING = 1e-6


def corrected_averages(networks: UrushiNetworks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Codes (n, L) that decode to averages f (n, P) at the probe pairs, by steps from z (n, L)."""
    return correct_codes_serial(networks, z, f, CORRECTION_DAMPING)[0]


class AverageCorrection(NamedTuple):
    """Regression that predicts the correction of encoded averages.

    Codes of which nothing was averaged stay unchanged.

    Attributes:
        features, coefficients: (F, L), the regression of the change.
        scale: (L,) one over the spread of codes.
        near: squared distance between the encoded average and the average of codes, in units of the
            spread, at which the change is halved.
    """

    features: CodeFeatures
    coefficients: np.ndarray
    scale: np.ndarray
    near: float

    def __call__(self, z: np.ndarray, rest: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """Corrected codes (n, L).

        Args:
            z: (n, L) encoded averages, remainder included.
            rest: (n, L) the encoder's remainder, averaged.
            mean: (n, L) averages of the codes.
        """
        change = self.features(_correction_inputs(z, rest)) @ self.coefficients
        change *= _correction_share(_distance(z, mean, self.scale), self.near)[:, None]
        return change + z


def fit_average_correction(
    z: np.ndarray, rest: np.ndarray, mean: np.ndarray, aim: np.ndarray
) -> AverageCorrection:
    """Fit the regression to averages, as in `AverageCorrection.__call__`, and corrected codes aim.

    The seed of the random features is fixed.
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
    """Inputs of the regression; the gain, the first number of a code, is none of them."""
    return np.concatenate([z[:, 1:], rest], axis=1)


def _distance(z: np.ndarray, mean: np.ndarray, scale: np.ndarray) -> np.ndarray:
    return np.square((z - mean) * scale).mean(axis=1)


def _correction_share(distance: np.ndarray, near: float) -> np.ndarray:
    return distance / (distance + near)


#: Number of codes that the regressions are fitted to; textures of fewer use the exact operations.
SAMPLE = 2048

#: Regression of values and remainder: number of random features, and ridge.
FEATURES, RIDGE = 128, 1e-6

#: Number of probe pairs that are kept, and of times that random halves of the sample are averaged:
#: averages of 2, 4, 8, ... codes.
KEPT_PAIRS, HALVINGS = 48, 4

#: Number of codes that are decoded at once, of those that measure the regression's error, and of
#: averages of each halving that the correction is fitted to.
DECODED_BLOCK, ERROR_SAMPLE, CORRECTION_SAMPLE = 8, 256, 256

#: Least spread of a number of a code that is not constant.
LEAST_SPREAD = 1e-4


class AveragingSpace(Protocol):
    """A space in which codes are averaged linearly."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """Representation (n, K) of codes (n, size) that averages linearly."""

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The codes (n, size) of averages (n, K)."""


class LatentSpace:
    """Averages of the codes themselves, as in Fan et al. (2022): for the paper's networks."""

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
        """Encode, add the remainder, and correct."""
        f, rest, _ = self.parts(means)
        z = self.networks.encode(f) + rest
        parts = [corrected_averages(self.networks, z[some], f[some]) for some in _blocks(z)]
        return np.concatenate(parts)

    def parts(self, means: np.ndarray) -> list[np.ndarray]:
        """Values (n, P), remainders (n, size) and codes (n, size) of averages."""
        return _split_means(means, len(self.networks.pairs()[0]))


class RegressionSpace(NamedTuple):
    """`DecodedSpace` by regressions.

    Attributes:
        exact: the space that is approximated.
        kept: (K,) indices of the probe pairs at which values are averaged.
        encode: makes codes of values at these pairs.
        settle: corrects these codes.
        features, coefficients: (F, K + size), the regression of ln f without the gain, and of the
            remainder.
        error: root mean square error of ln f after `lift` and `drop`, over the sample.
    """

    exact: DecodedSpace
    kept: np.ndarray
    encode: Callable[[np.ndarray], np.ndarray]
    settle: AverageCorrection
    features: CodeFeatures
    coefficients: np.ndarray
    error: float

    def lift(self, z: np.ndarray) -> np.ndarray:
        """Estimates of f (n, K) and z - E(f); and z."""
        estimated = self.features(z) @ self.coefficients
        logs = estimated[:, : len(self.kept)]
        logs += z[:, :1]
        np.exp(logs, out=logs)
        return np.concatenate([estimated, z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, add the remainder, and correct by the regression."""
        f, rest, mean = _split_means(means, len(self.kept))
        return self.settle(self.encode(f) + rest, rest, mean)

    def fits(self, z: np.ndarray) -> bool:
        """Whether the error for codes (n, size) is similar to that for the sample."""
        return self.distance(z) <= 2 * self.error + 0.01

    def distance(self, z: np.ndarray) -> float:
        """Root mean square error of ln f of codes (n, size) after `lift` and `drop`."""
        lifted = (self.exact.lift(codes) for codes in (z, self.drop(self.lift(z))))
        f, again = (self.exact.parts(rows)[0] for rows in lifted)
        return float(np.sqrt(np.square(np.log(again / f)).mean()))


def averaging_space(
    model: Model, read: Callable[[np.ndarray], np.ndarray], count: int
) -> AveragingSpace:
    """The averaging space for a texture of `count` codes.

    read: gives codes (n, size) by their indices. The seed of the sample is fixed.
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
    """Features and coefficients of `RegressionSpace`, from exactly lifted codes (n, size)."""
    features = regression.fit_features(z, FEATURES, LEAST_SPREAD, rng)
    target = np.concatenate([np.log(f[:, kept]) - z[:, :1], rest], axis=1)
    return features, regression.ridge_coefficients(features(z), target, RIDGE)


def _fit_correction(
    exact: DecodedSpace,
    kept: np.ndarray,
    encode: Callable[[np.ndarray], np.ndarray],
    means: np.ndarray,
) -> AverageCorrection:
    """The correction for averages (n, P + 2 size) that are encoded by the kept pairs."""
    f, rest, mean = exact.parts(means)
    start = encode(f[:, kept]) + rest
    aim = np.empty_like(start)
    fill_blocks(aim, partial(corrected_averages, exact.networks), start, f, rows=DECODED_BLOCK)
    with one_blas_thread():
        return fit_average_correction(start, rest, mean, aim)


def _blocks(rows: np.ndarray) -> list[slice]:
    """Blocks of rows whose decoded values fit into a core's cache."""
    return [slice(start, start + DECODED_BLOCK) for start in range(0, len(rows), DECODED_BLOCK)]


def _split_means(rows: np.ndarray, pairs: int) -> list[np.ndarray]:
    """Split rows (n, pairs + 2 size) into values, remainders and codes."""
    return np.split(rows, [pairs, (pairs + rows.shape[1]) // 2], axis=1)


def _reduced_encoder(
    networks: UrushiNetworks, f: np.ndarray
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Indices (K,) of pairs that predict the encoder's input best, and an encoder of these.

    The pairs are the pivots of a Cholesky factorisation of the covariance over f (n, P): each is
    the pair with the greatest variance given those before it.
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
    indices = np.array(kept)
    return indices, networks.reduced_encoder(
        indices, matrix.astype(np.float32), offset.astype(np.float32)
    )
