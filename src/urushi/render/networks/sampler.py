"""The sampler in Dr.Jit: the counterpart of `nets.sampler`."""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.nets.features import MIN_COSINE
from urushi.nets.sampler import MIN_COSINE_SHARE
from urushi.nets.weights import Model
from urushi.physics.mixture import Mixture
from urushi.render.networks import mlp
from urushi.render.networks.cooperative import hidden_layers


class UrushiSampler:
    """Proposals from latent codes and the cosine of wi; see `protocols.Sampler`.

    A proposal is a mixture of GGX reflection lobes and a cosine lobe (`physics.mixture`), whose
    weights and widths the network gives. The terms of a code (width) are its part of the first
    layer's pre-activation.
    """

    def __init__(self, model: Model, cooperative: bool | None = None):
        """cooperative: see `cooperative.hidden_layers`."""
        params, activation = model.params, model.arch.activation
        self._hidden = hidden_layers(params, "sampler", activation, cooperative)
        self._lobes = model.arch.lobes
        weight = model.params["sampler.0.weight"]
        self._from_latent = weight[: model.arch.latent]
        self._from_angle = weight[model.arch.latent :]
        self._bias = model.params["sampler.0.bias"]

    def code_terms(self, latent: np.ndarray) -> np.ndarray:
        """Terms (..., width) of latent codes (..., 32)."""
        return latent @ self._from_latent + self._bias

    def proposal_of_terms(self, terms: Sequence, cos_i) -> Mixture:
        """The mixture for wi of cosine cos_i, from a list (width) of Dr.Jit floats."""
        first = mlp.dense(sampler_features(cos_i), self._from_angle, terms)
        return self._mixture(self._hidden(first))

    def proposal(self, latent: Sequence, cos_i) -> Mixture:
        """The same from a latent code, a list (32) of Dr.Jit floats."""
        terms = mlp.dense(latent, self._from_latent, self._bias.tolist())
        return self.proposal_of_terms(terms, cos_i)

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


def sampler_features(cos_i):
    """The sampler's two features of the cosine of wi, as a list."""
    raised = dr.maximum(cos_i, MIN_COSINE)
    return [(raised - 0.5) * 3, dr.log(raised) + 1]
