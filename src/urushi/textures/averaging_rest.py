"""Averages of the rests of codes, without their lobes, of `textures.averaging`.

A texture has millions of codes, which cannot all be decoded. They lie close together, however. For
large textures two regressions, fitted to a sample of the texture's codes, replace the decoder and
the Gauss-Newton steps. The first predicts ln D(z) at a few probe pairs, and the residual. The
second predicts the change that the steps would make.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from urushi.material import regression
from urushi.material.correction import correct_codes_serial
from urushi.material.regression import CodeFeatures
from urushi.nets import decoder, encoder
from urushi.nets.features import direction_features
from urushi.nets.lobe import no_lobe
from urushi.nets.networks import UrushiNetworks
from urushi.parallel import fill_blocks, one_blas_thread

#: Number of codes in the sample. Textures with no more codes are decoded exactly.
SAMPLE = 2048

#: Regression of decoded values: number of random features, ridge, and the least spread of a number
#: of the code that counts as variation.
FEATURES, RIDGE, LEAST_SPREAD = 128, 1e-6, 1e-4

#: Number of probe pairs whose values are predicted; the encoder derives the others from them.
KEPT_PAIRS = 48

#: The sample is mixed this many times: averages of 2, 4, ..., 2^HALVINGS random codes.
HALVINGS = 4

#: Codes decoded at a time at all pairs; averages of each mixture that fit the correction.
DECODED_BLOCK, CORRECTION_SAMPLE = 8, 256

#: Damping of the Gauss-Newton steps. It is larger than for encoded sources, because a regression
#: cannot predict numbers of a code on which the values hardly depend.
CORRECTION_DAMPING = 1e-2

#: Regression of the correction, as above.
CORRECTION_FEATURES, CORRECTION_RIDGE, CORRECTION_LEAST_SPREAD = 128, 1e-3, 1e-4

#: The correction is halved where an average moves its code by this share of the median distance:
#: there the averaged codes are almost equal. The fit divides by a share of at least the second.
NEAR_SHARE, LEAST_SHARE = 0.05, 0.05

#: Squared rounding error of averaged codes, in units of their spread.
ROUNDING = 1e-6


def rest_space(
    networks: UrushiNetworks, read: Callable[[np.ndarray], np.ndarray], count: int
) -> "DecodedSpace | RegressionSpace":
    """The space in which rests are averaged.

    Args:
        networks: Urushi's own.
        read: from indices below `count` to the rests (n, R) of codes.
        count: number of codes in the texture.
    """
    exact = DecodedSpace(networks)
    if count <= SAMPLE:
        return exact
    rng = np.random.default_rng(0)
    z = read(rng.integers(count, size=SAMPLE)).astype(np.float32)
    points = np.empty((len(z), len(networks.pairs()[0]) + 2 * z.shape[1]), np.float32)
    fill_blocks(points, exact.lift, z, rows=DECODED_BLOCK)
    mixtures = [points]
    for _ in range(HALVINGS):
        mixtures.append(0.5 * (mixtures[-1] + rng.permutation(mixtures[-1])))
    with one_blas_thread():
        kept, encode = _reduced_encoder(
            networks, np.concatenate([exact.split(part)[0] for part in mixtures])
        )
        f, residual, _ = exact.split(points)
        features, coefficients = _fit_decoder(z, f, residual, kept, rng)
    correct = _fit_correction(
        exact, kept, encode, np.concatenate([part[:CORRECTION_SAMPLE] for part in mixtures[1:]])
    )
    return RegressionSpace(exact, kept, encode, correct, features, coefficients)


class DecodedSpace(NamedTuple):
    """Values at all P probe pairs, the residual, and the code: K = P + 2 L. Exact, but slow.

    Codes (n, L) have the numbers of the rest only, not of the lobe.
    """

    networks: UrushiNetworks

    def lift(self, z: np.ndarray) -> np.ndarray:
        """f (n, P), z - E(f) (n, L) and z (n, L), side by side."""
        features = direction_features(*self.networks.pairs(), self.networks.arch.widths)
        f = np.concatenate([self._decoded(z[rows], features) for rows in _blocks(z)])
        return np.concatenate([f, z - self._encoded(f), z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, add the residual, and take the Gauss-Newton steps."""
        f, residual, _ = self.split(means)
        z = self._encoded(f) + residual
        blocks = [corrected_averages(self.networks, z[rows], f[rows]) for rows in _blocks(z)]
        return np.concatenate(blocks)

    def _decoded(self, z: np.ndarray, features: np.ndarray) -> np.ndarray:
        return decoder.decode(self.networks.params, self.networks.arch, z[:, None], features)

    def _encoded(self, f: np.ndarray) -> np.ndarray:
        return encoder.encode(self.networks.params, self.networks.arch, f)

    def split(self, means: np.ndarray) -> list[np.ndarray]:
        """Values (n, P), residuals (n, L) and codes (n, L) of points."""
        return _split(means, len(self.networks.pairs()[0]))


class RegressionSpace(NamedTuple):
    """`DecodedSpace` at K of the probe pairs, by regressions in place of decoder and steps.

    Attributes:
        exact: the space that this one approximates.
        kept: (K,) indices of the probe pairs.
        encode: from values (n, K) at these to codes.
        correct: the regression that replaces the Gauss-Newton steps.
        features, coefficients: (F, K + L) of the regression that replaces the decoder. The first K
            columns give ln f less the gain, the others the residual.
    """

    exact: DecodedSpace
    kept: np.ndarray
    encode: Callable[[np.ndarray], np.ndarray]
    correct: "AverageCorrection"
    features: CodeFeatures
    coefficients: np.ndarray

    def lift(self, z: np.ndarray) -> np.ndarray:
        """Estimates of f (n, K) and of the residual (n, L), and z (n, L), side by side."""
        estimates = self.features(z) @ self.coefficients
        log_f = estimates[:, : len(self.kept)]
        log_f += z[:, :1]
        np.exp(log_f, out=log_f)
        return np.concatenate([estimates, z], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Encode, add the residual, and add the estimated correction."""
        f, residual, mean = _split(means, len(self.kept))
        return self.correct(self.encode(f) + residual, residual, mean)


class AverageCorrection(NamedTuple):
    """The regression that replaces the Gauss-Newton steps.

    Where the averaged codes are equal, there is nothing to correct; the change vanishes there.

    Attributes:
        features, coefficients: (F, L), of the change.
        scale: (L,) the inverse spread of the codes.
        near: the squared distance, in units of the spread, between the encoded average and the
            average of the codes at which the change is halved.
    """

    features: CodeFeatures
    coefficients: np.ndarray
    scale: np.ndarray
    near: float

    def __call__(self, z: np.ndarray, residual: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """Corrected codes (n, L).

        Args:
            z: (n, L) the encoded averages, residual included.
            residual: (n, L) the averaged residuals.
            mean: (n, L) the averages of the codes.
        """
        change = self.features(_correction_inputs(z, residual)) @ self.coefficients
        change *= _share(_distance(z, mean, self.scale), self.near)[:, None]
        return change + z


def corrected_averages(networks: UrushiNetworks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Codes (n, L) closer to averages f (n, P) at the probe pairs than z (n, L): Gauss-Newton."""
    none = np.array(no_lobe(networks.arch.widths), np.float32)
    whole = np.concatenate([np.tile(none, (len(z), 1)), z], axis=1)
    return correct_codes_serial(networks, whole, f, CORRECTION_DAMPING)[0][:, len(none) :]


def fit_average_correction(
    z: np.ndarray, residual: np.ndarray, mean: np.ndarray, target: np.ndarray
) -> AverageCorrection:
    """Fit the regression to averages and their codes after the Gauss-Newton steps.

    Args:
        z, residual, mean: (n, L) as of `AverageCorrection.__call__`.
        target: (n, L) what `corrected_averages` makes of z.

    The seed of the random features is fixed.
    """
    spread = mean.std(axis=0)
    scale = 1 / (spread + 0.01 * spread.max() + CORRECTION_LEAST_SPREAD)
    distance = _distance(z, mean, scale)
    near = NEAR_SHARE * float(np.median(distance)) + ROUNDING
    share = np.maximum(_share(distance, near), LEAST_SHARE)
    inputs = _correction_inputs(z, residual)
    features = regression.fit_features(
        inputs, CORRECTION_FEATURES, CORRECTION_LEAST_SPREAD, np.random.default_rng(0)
    )
    coefficients = regression.ridge_coefficients(
        features(inputs), (target - z) / share[:, None], CORRECTION_RIDGE, weights=share**2
    )
    return AverageCorrection(features, coefficients, scale, near)


def _correction_inputs(z: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Inputs (n, 2 L - 1) of the correction, which does not depend on the gain."""
    return np.concatenate([z[:, 1:], residual], axis=1)


def _distance(z: np.ndarray, mean: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Mean squared distances (n,) in units of the spread."""
    return np.square((z - mean) * scale).mean(axis=1)


def _share(distance: np.ndarray, near: float) -> np.ndarray:
    """The share of the correction (n,) that is applied: 0 at distance 0, 1/2 at `near`."""
    return distance / (distance + near)


def _fit_decoder(
    z: np.ndarray, f: np.ndarray, residual: np.ndarray, kept: np.ndarray, rng: np.random.Generator
) -> tuple[CodeFeatures, np.ndarray]:
    """Features and coefficients of `RegressionSpace`, from codes (n, L) and their exact values."""
    features = regression.fit_features(z, FEATURES, LEAST_SPREAD, rng)
    target = np.concatenate([np.log(f[:, kept]) - z[:, :1], residual], axis=1)
    return features, regression.ridge_coefficients(features(z), target, RIDGE)


def _fit_correction(
    exact: DecodedSpace,
    kept: np.ndarray,
    encode: Callable[[np.ndarray], np.ndarray],
    means: np.ndarray,
) -> AverageCorrection:
    """The correction of averages (n, P + 2 L) that are encoded from their values at `kept`."""
    f, residual, mean = exact.split(means)
    start = encode(f[:, kept]) + residual
    target = np.empty_like(start)
    fill_blocks(target, partial(corrected_averages, exact.networks), start, f, rows=DECODED_BLOCK)
    with one_blas_thread():
        return fit_average_correction(start, residual, mean, target)


def _reduced_encoder(
    networks: UrushiNetworks, f: np.ndarray
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Choose the kept probe pairs (K,), and an encoder that needs the values at these alone.

    f: (n, P) values of codes and of their averages. A pivoted Cholesky factorisation of the
    covariance of the encoder's inputs chooses the pairs: each is the one that the pairs before it
    predict worst. The inputs at the other pairs follow by linear regression.
    """
    inputs = networks.normalised(f).astype(np.float64)
    mean = inputs.mean(axis=0)
    covariance = np.cov(inputs, rowvar=False) + RIDGE * np.eye(len(mean))
    remaining, pivots = covariance.copy(), []
    for _ in range(min(KEPT_PAIRS, len(mean))):
        pivots.append(int(remaining.diagonal().argmax()))
        column, row = remaining[:, pivots[-1]], remaining[pivots[-1]]
        remaining -= np.outer(column, row) / remaining[pivots[-1], pivots[-1]]
    matrix = np.linalg.solve(covariance[np.ix_(pivots, pivots)], covariance[pivots])
    offset = mean - mean[pivots] @ matrix
    kept = np.array(pivots)
    return kept, networks.reduced_encoder(
        kept, matrix.astype(np.float32), offset.astype(np.float32)
    )


def _blocks(rows: np.ndarray) -> list[slice]:
    """Slices of rows whose decoded values fit into a core's cache."""
    return [slice(start, start + DECODED_BLOCK) for start in range(0, len(rows), DECODED_BLOCK)]


def _split(points: np.ndarray, pairs: int) -> list[np.ndarray]:
    """Cut points (n, pairs + 2 L) into values, residuals and codes."""
    return np.split(points, [pairs, (pairs + points.shape[1]) // 2], axis=1)
