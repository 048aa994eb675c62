"""The decoder in Dr.Jit: the twin of `nets.decoder`, for several channels that share directions."""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.weights import Model
from urushi.render import network
from urushi.render.features import direction_features


class Decoder:
    """f [1/sr] from a model's latent codes, given as such or as their first layer's share.

    A constant material multiplies its latent code with the first layer once, on the host
    (`first_layer`); a textured one does so at every evaluation.
    """

    def __init__(self, model: Model):
        self._params = model.params
        self._activation = model.arch.activation
        weight = model.params["decoder.0.weight"]
        codes = model.arch.latent - 1  # the gain bypasses the network
        self._from_latent, self._from_features = weight[:codes], weight[codes:]
        self._bias = model.params["decoder.0.bias"]

    def first_layer(self, latents: np.ndarray) -> np.ndarray:
        """The latents' gain and share of the first layer: (..., 32) -> (..., 1 + width)."""
        share = latents[..., 1:] @ self._from_latent + self._bias
        return np.concatenate([latents[..., :1], share], axis=-1)

    def of_first_layer(self, shares: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; shares: per channel a list (1 + width) of Dr.Jit floats."""
        zeros = [0.0] * len(self._bias)
        common = network.dense(direction_features(wi, wo), self._from_features, zeros)
        return [
            network.compiled_once(
                self._rest, gain, *(a + b for a, b in zip(common, share, strict=True))
            )
            for gain, *share in shares
        ]

    def of_latents(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; latents: per channel a list (32) of Dr.Jit floats."""
        features = direction_features(wi, wo)
        return [network.compiled_once(self._whole, *z, *features) for z in latents]

    def _rest(self, gain, *first):
        output = network.hidden_to_output(self._params, "decoder", first, self._activation)[0]
        return dr.exp(dr.clip(gain + output, MIN_LOG, MAX_LOG))

    def _whole(self, gain, *inputs):
        weight = np.concatenate([self._from_latent, self._from_features])
        return self._rest(gain, *network.dense(inputs, weight, self._bias.tolist()))
