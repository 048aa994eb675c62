"""The sampling proposal in Dr.Jit: the twin of `nets.sampler` and `nets.sampler`.

A mixture of GGX reflection lobes and a cosine lobe (`physics.mixture`), its weights and widths from
the proposal network.
"""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.nets.features import MIN_ALPHA
from urushi.nets.sampler import MIN_COSINE_SHARE
from urushi.nets.weights import Model
from urushi.physics.mixture import Mixture
from urushi.render.networks import mlp
from urushi.render.networks.cooperative import hidden_layers
from urushi.render.networks.features import sampler_features


class Proposal:
    """Mixtures from a model's latent codes and the cosine of wi."""

    def __init__(self, model: Model, cooperative: bool | None = None):
        """cooperative: see `hidden.choose`."""
        params, activation = model.params, model.arch.activation
        self._rest = hidden_layers(params, "sampler", activation, cooperative)
        self._lobes = model.arch.lobes
        weight = model.params["sampler.0.weight"]
        self._from_latent = weight[: model.arch.latent]
        self._from_angle = weight[model.arch.latent :]
        self._bias = model.params["sampler.0.bias"]

    def first_layer(self, latent: np.ndarray) -> np.ndarray:
        """The latent's share of the first layer's pre-activation: (..., 32) -> (..., width)."""
        return latent @ self._from_latent + self._bias

    def of_first_layer(self, share: Sequence, cos_i) -> Mixture:
        """The mixture for wi of cosine cos_i; share: a list (width) of Dr.Jit floats."""
        first = mlp.dense(sampler_features(cos_i), self._from_angle, share)
        return self._mixture(self._rest(first))

    def of_latent(self, latent: Sequence, cos_i) -> Mixture:
        """The same from a latent code, a list (32) of Dr.Jit floats."""
        share = mlp.dense(latent, self._from_latent, self._bias.tolist())
        return self.of_first_layer(share, cos_i)

    def _mixture(self, output: Sequence) -> Mixture:
        k = self._lobes
        logits = output[: k + 1]
        largest = logits[0]
        for logit in logits[1:]:
            largest = dr.maximum(largest, logit)
        shares = [dr.exp(logit - largest) for logit in logits]
        scale = (1 - MIN_COSINE_SHARE) / sum(shares)
        weights = [share * scale for share in shares]
        weights[k] = weights[k] + MIN_COSINE_SHARE
        fractions = [1 / (1 + dr.exp(x)) for x in output[k + 1 :]]
        alphas = [dr.clip(dr.exp(float(np.log(MIN_ALPHA)) * x), MIN_ALPHA, 1) for x in fractions]
        return Mixture(weights, alphas)
