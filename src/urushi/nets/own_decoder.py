"""Decoders of single BRDFs: a small network whose weights belong to one channel of one material.

Such a network replaces the common decoder and its code where a BRDF is known at many pairs of
directions. Its inputs are those of the decoder, so that f is reciprocal to the bit. For the
features x of a pair of directions, the rest of the BRDF, f less its lobe (`urushi.nets.lobe`), is

    exp(gain + output . activate(first^T x + offset)).

The weights of a channel are one row of `WEIGHTS` numbers: first, row by row, then offset, output
and gain.
"""

from typing import Any, NamedTuple

import numpy as np

from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.features import DIRECTION_FEATURES
from urushi.nets.mlp import activate, product, with_slope

#: Units of the hidden layer.
HIDDEN = 24

#: Numbers of one channel.
WEIGHTS = (DIRECTION_FEATURES + 2) * HIDDEN + 1

#: Activation of the hidden layer (`mlp.POLYNOMIALS`).
ACTIVATION = "silu7"


class OwnWeights(NamedTuple):
    """Views of the weights of one channel.

    Attributes:
        first: (8, `HIDDEN`); offset, output: (`HIDDEN`,); gain: ().
    """

    first: Any
    offset: Any
    output: Any
    gain: Any


def split(weights: np.ndarray) -> OwnWeights:
    """The parts of a channel's weights (`WEIGHTS`,)."""
    count = DIRECTION_FEATURES * HIDDEN
    first = weights[:count].reshape(DIRECTION_FEATURES, HIDDEN)
    offset, output = weights[count:-1].reshape(2, HIDDEN)
    return OwnWeights(first, offset, output, weights[-1])


def rest(weights: np.ndarray, features: np.ndarray) -> np.ndarray:
    """The rests (N, C) [1/sr] of weights (C, `WEIGHTS`) at `direction_features` (N, 8)."""
    logs = np.empty((len(features), len(weights)), features.dtype)
    for channel, row in enumerate(weights):
        own = split(row)
        hidden = activate(product(features, own.first) + own.offset, ACTIVATION)
        logs[:, channel] = own.gain + hidden @ own.output
    return np.exp(logs.clip(MIN_LOG, MAX_LOG))


def log_rest_slopes(weights: np.ndarray, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms (N,) of the rest of one channel, and derivatives (N, `WEIGHTS`) by its weights.

    Neither is clamped.
    """
    own = split(weights)
    hidden, slope = with_slope(product(features, own.first) + own.offset, ACTIVATION)
    slope *= own.output
    count = DIRECTION_FEATURES * HIDDEN
    slopes = np.empty((len(features), WEIGHTS), features.dtype)
    products = slopes[:, :count].reshape(-1, DIRECTION_FEATURES, HIDDEN)
    np.multiply(features[:, :, None], slope[:, None], out=products)
    slopes[:, count:-1] = np.concatenate([slope, hidden], axis=-1)
    slopes[:, -1] = 1.0
    return own.gain + hidden @ own.output, slopes


def scaled(weights: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """Weights (C, `WEIGHTS`) of `factor` (C,) > 0 times the rests."""
    result = np.array(weights)
    result[:, -1] += np.log(factor)
    return result
