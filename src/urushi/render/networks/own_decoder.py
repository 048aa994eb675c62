"""Decoders of single BRDFs in Dr.Jit: the counterpart of `nets.own_decoder`, for all channels.

The weights are constants in the code, as those of the common decoder are (`mlp`), so that each
material has code of its own.
"""

import hashlib
from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.nets import own_decoder
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.render.networks import lobe, mlp
from urushi.render.networks.decoder import direction_features
from urushi.render.networks.lobe import LobeKind

#: Number of small numbers, each below `STATES`, that identify a set of weights.
DIGITS, STATES = 16, 5


class OwnDecoder:
    """f [1/sr] of a constant material: that of its codes' lobes and of decoders of its own.

    The terms of a channel are the numbers of its lobe that `LobeKind.numbers` names.
    """

    def __init__(self, weights: np.ndarray, kind: LobeKind):
        """weights: (C, `nets.own_decoder.WEIGHTS`). kind: of the lobes."""
        self._channels = [own_decoder.split(row) for row in weights]
        self._kind = kind

    def code_terms(self, latents: np.ndarray) -> list[np.ndarray]:
        """Terms (K,) of the code of each channel, from codes (C, size)."""
        return [code[self._kind.numbers(c)] for c, code in enumerate(latents)]

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list of Dr.Jit floats, its terms, for each."""
        features = direction_features(wi, wo)
        rests = [_rest(own, features) for own in self._channels]
        if not self._kind.present:
            return rests
        values = lobe.f(self._kind.complete(terms), wi, wo, self._kind)
        return [a + b for a, b in zip(values, rests, strict=True)]


def _rest(own: own_decoder.OwnWeights, features: list):
    """The rest [1/sr] of a channel."""
    first = mlp.dense(features, own.first, own.offset.tolist())
    hidden = [mlp.activate(value, own_decoder.ACTIVATION) for value in first]
    (log_rest,) = mlp.dense(hidden, own.output[:, None], [float(own.gain)])
    return dr.exp(dr.clip(log_rest, MIN_LOG, MAX_LOG))


def digits(weights: np.ndarray) -> list[int]:
    """Small numbers by which frozen functions tell weights from others (`recording.signature`)."""
    value = int.from_bytes(hashlib.sha256(weights.tobytes()).digest()[:8], "little")
    return [value // STATES**k % STATES for k in range(DIGITS)]
