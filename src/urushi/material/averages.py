"""What the code of an average lacks once it is encoded, as a regression.

Two steps of Gauss and Newton bring an encoded average of unlike BRDFs five times closer to its
values (`correct`). Millions of texels have no time for them: a regression on some averages of a
texture tells what they would change.
"""

from typing import NamedTuple

import numpy as np

from urushi.material import regression
from urushi.material.correct import closer
from urushi.material.regression import Features
from urushi.nets.networks import OnePass

#: Damping of the steps: more than for what is encoded, as a regression cannot follow what small
#: changes of the values do to numbers of a code that they hardly determine.
DAMPING = 1e-2

#: Of the regression: random features besides the numbers themselves, its ridge, and the least
#: spread of a number that means anything.
FEATURES, RIDGE, LEAST_SPREAD = 128, 1e-3, 1e-4

#: What is closer than this share of the typical distance is hardly an average, and left alone; and
#: no change is divided by less when the regression is fitted.
NEAR, LEAST_SHARE = 0.05, 0.05

#: Averages of codes are known to this, in units of their spread, squared.
ROUNDING = 1e-6


def exact(networks: OnePass, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Codes (n, L) that decode to averages f (n, P) at the probe pairs, starting at z (n, L)."""
    return closer(networks, z, f, DAMPING)[0]


class Settling(NamedTuple):
    """The same by a regression; where nothing was averaged, codes stay as they are.

    Attributes:
        features, coefficients: (F, L), of the change.
        scale: (L,) one over the spread of codes.
        near: where the change is halved: a squared distance between the encoded average and the
            average of codes, in units of the spread.
    """

    features: Features
    coefficients: np.ndarray
    scale: np.ndarray
    near: float

    def __call__(self, z: np.ndarray, rest: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """Codes (n, L).

        z: (n, L) as encoded; rest: (n, L) the part of it that the encoder has not told; mean:
        (n, L) of the codes that were averaged.
        """
        change = self.features(_seen(z, rest)) @ self.coefficients
        change *= _share(_distance(z, mean, self.scale), self.near)[:, None]
        return change + z


def settling(z: np.ndarray, rest: np.ndarray, mean: np.ndarray, aim: np.ndarray) -> Settling:
    """The regression from averages as for `Settling.__call__` and what `exact` makes of them.

    Its random features' seed is fixed.
    """
    spread = mean.std(axis=0)
    scale = 1 / (spread + 0.01 * spread.max() + LEAST_SPREAD)
    distance = _distance(z, mean, scale)
    near = NEAR * float(np.median(distance)) + ROUNDING
    share = np.maximum(_share(distance, near), LEAST_SHARE)
    seen = _seen(z, rest)
    features = regression.features(seen, FEATURES, LEAST_SPREAD, np.random.default_rng(0))
    coefficients = regression.coefficients(
        features(seen), (aim - z) / share[:, None], RIDGE, weights=share**2
    )
    return Settling(features, coefficients, scale, near)


def _seen(z: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """What the change depends on: not on the gain, the first number of a code."""
    return np.concatenate([z[:, 1:], rest], axis=1)


def _distance(z: np.ndarray, mean: np.ndarray, scale: np.ndarray) -> np.ndarray:
    return np.square((z - mean) * scale).mean(axis=1)


def _share(distance: np.ndarray, near: float) -> np.ndarray:
    return distance / (distance + near)
