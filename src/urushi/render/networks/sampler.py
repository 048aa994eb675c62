"""The sampler in Dr.Jit: the counterpart of `nets.sampler`."""

from collections.abc import Sequence

import drjit as dr
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.nets.features import MIN_COSINE
from urushi.nets.sampler import MIN_COSINE_SHARE, sampler_inputs
from urushi.nets.weights import Model
from urushi.physics.mixture import Mixture
from urushi.render.networks import mlp
from urushi.render.networks.cooperative import hidden_layers
from urushi.render.networks.lobe import LobeKind, lobe_features


class UrushiSampler:
    """Proposals from latent codes and the cosine of wi; see `protocols.Sampler`.

    A proposal is a mixture of GGX reflection lobes and a cosine lobe (`physics.mixture`), whose
    weights and widths the network gives; the first width is that of the code's own lobe. The terms
    of a code (1 + width) are that width and its part of the first layer's pre-activation.
    """

    def __init__(self, model: Model, kind: LobeKind, cooperative: bool | None = None):
        """kind: what is known of the codes' lobes. cooperative: see `cooperative.hidden_layers`."""
        params, activation = model.params, model.arch.activation
        self._hidden = hidden_layers(params, "sampler", activation, cooperative)
        self._arch, self._kind = model.arch, kind
        weight = model.params["sampler.0.weight"]
        self._from_code, self._from_angle = weight[:-2], weight[-2:]
        self._bias = model.params["sampler.0.bias"]

    def code_terms(self, latent: np.ndarray) -> np.ndarray:
        """Terms of a latent code (size,)."""
        inputs = sampler_inputs(self._arch, latent[None])[0]
        own = latent[: 1 if self._arch.lobe else 0]
        return np.concatenate([own, inputs @ self._from_code + self._bias])

    def proposal_of_terms(self, terms: Sequence, cos_i) -> Mixture:
        """The mixture for wi of cosine cos_i, from a list of Dr.Jit floats."""
        own = 1 if self._arch.lobe else 0
        first = mlp.dense(sampler_features(cos_i), self._from_angle, terms[own:])
        return self._mixture(terms[:own], self._hidden(first))

    def proposal(self, latent: Sequence, cos_i) -> Mixture:
        """The same from a latent code, a list (size) of Dr.Jit floats."""
        inputs, lobe = list(latent), self._arch.lobe
        if lobe:
            inputs = [*lobe_features(latent[:lobe], self._kind), *latent[lobe:]]
        terms = mlp.dense(inputs, self._from_code, self._bias.tolist())
        return self.proposal_of_terms([*latent[: 1 if lobe else 0], *terms], cos_i)

    def _mixture(self, own: Sequence, output: Sequence) -> Mixture:
        k = len(own) + self._arch.lobes
        logits = output[: k + 1]
        largest = logits[0]
        for logit in logits[1:]:
            largest = dr.maximum(largest, logit)
        shares = [dr.exp(logit - largest) for logit in logits]
        scale = (1 - MIN_COSINE_SHARE) / sum(shares)
        weights = [share * scale for share in shares]
        weights[k] = weights[k] + MIN_COSINE_SHARE
        fractions = [1 / (1 + dr.exp(x)) for x in output[k + 1 :]]
        alphas = [dr.exp(float(np.log(MIN_ALPHA)) * x) for x in fractions]
        return Mixture(weights, [dr.clip(alpha, MIN_ALPHA, 1) for alpha in (*own, *alphas)])


def sampler_features(cos_i):
    """The sampler's two features of the cosine of wi, as a list."""
    raised = dr.maximum(cos_i, MIN_COSINE)
    return [(raised - 0.5) * 3, dr.log(raised) + 1]
