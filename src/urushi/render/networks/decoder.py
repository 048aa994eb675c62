"""The decoder in Dr.Jit: the twin of `nets.decoder`, for several channels that share directions."""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.nets.architecture import SCALE
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.weights import Model
from urushi.render.networks import mlp
from urushi.render.networks.cooperative import hidden_layers
from urushi.render.networks.features import direction_features


class Decoder:
    """f [1/sr] from a model's latent codes, given as such or as their first layer's share.

    A constant material multiplies its latent code with the first layer once, on the host
    (`first_layer`); a textured one does so at every evaluation.
    """

    def __init__(self, model: Model, cooperative: bool | None = None):
        """cooperative: see `hidden.choose`."""
        params, activation = model.params, model.arch.activation
        self._rest = hidden_layers(params, "decoder", activation, cooperative)
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

    def share(self, latent: Sequence) -> list:
        """The same from a latent code, a list (32) of Dr.Jit floats: a list (1 + 2 width)."""
        return [latent[0], *mlp.compiled_once(self._share, *latent[1:])]

    def of_first_layer(self, shares: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; shares: per channel a list (1 + 2 width) of Dr.Jit floats."""
        # The response to the directions is the same for all channels.
        response = mlp.dense(direction_features(wi, wo), self._response, [0.0] * len(self._bias))
        return [mlp.compiled_once(self._of_share, *share, *response) for share in shares]

    def of_latents(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel; latents: per channel a list (32) of Dr.Jit floats."""
        return self.of_first_layer([self.share(z) for z in latents], wi, wo)

    def _share(self, *z):
        scales = mlp.dense(z, self._scale, [1.0] * len(self._bias))
        return [*scales, *mlp.dense(z, self._offset, self._bias.tolist())]

    def _of_share(self, gain, *rest):
        width = len(self._bias)
        scales, offsets, response = rest[:width], rest[width : 2 * width], rest[2 * width :]
        first = [dr.fma(*values) for values in zip(scales, response, offsets, strict=True)]
        return dr.exp(dr.clip(gain + self._rest(first)[0], MIN_LOG, MAX_LOG))
