"""The decoder in Dr.Jit: the twin of `nets.decoder`, for several channels that share directions."""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.nets.architecture import SCALE
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
        self._offset, self._response = weight[:codes], weight[codes:]
        self._scale = model.params[SCALE]
        self._bias = model.params["decoder.0.bias"]

    def first_layer(self, latents: np.ndarray) -> np.ndarray:
        """What a constant material needs of its latents: (..., 32) -> (..., 1 + 2 width).

        The gain, the first layer's scales and its offsets.
        """
        gain, z = latents[..., :1], latents[..., 1:]
        return np.concatenate([gain, 1 + z @ self._scale, z @ self._offset + self._bias], axis=-1)

    def of_first_layer(self, shares: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; shares: per channel a list (1 + 2 width) of Dr.Jit floats."""
        response = self._responses(wi, wo)
        return [network.compiled_once(self._of_share, *share, *response) for share in shares]

    def of_latents(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; latents: per channel a list (32) of Dr.Jit floats."""
        response = self._responses(wi, wo)
        return [network.compiled_once(self._of_latent, *z, *response) for z in latents]

    def _responses(self, wi, wo) -> list:
        """The first layer's response to the directions, which all channels share."""
        return network.dense(direction_features(wi, wo), self._response, [0.0] * len(self._bias))

    def _of_share(self, gain, *rest):
        width = len(self._bias)
        return self._rest(gain, rest[:width], rest[width : 2 * width], rest[2 * width :])

    def _of_latent(self, gain, *rest):
        z, response = rest[: len(self._offset)], rest[len(self._offset) :]
        scales = network.dense(z, self._scale, [1.0] * len(self._bias))
        offsets = network.dense(z, self._offset, self._bias.tolist())
        return self._rest(gain, scales, offsets, response)

    def _rest(self, gain, scales, offsets, response):
        first = [dr.fma(*values) for values in zip(scales, response, offsets, strict=True)]
        output = network.hidden_to_output(self._params, "decoder", first, self._activation)[0]
        return dr.exp(dr.clip(gain + output, MIN_LOG, MAX_LOG))
