"""The proposal network: from a latent code and an angle to the mixture that `lobes` samples."""

from typing import Any

from urushi.nets.architecture import Architecture, Params
from urushi.nets.features import MIN_ALPHA, MIN_COSINE
from urushi.nets.mlp import hidden_to_output, split_linear

#: The cosine lobe never gets less than this: it bounds f_cos / pdf where the network is wrong.
MIN_COSINE_SHARE = 0.02
_LOG_MIN_ALPHA = -4.605170185988092


def sampler_features(cos_i: Any) -> Any:
    """Return the angle's two features (..., 2): the cosine and its logarithm, normalised."""
    xp = cos_i.__array_namespace__()
    raised = xp.maximum(cos_i, MIN_COSINE)
    return xp.stack([(raised - 0.5) * 3.0, xp.log(raised) + 1.0], axis=-1)


def lobes(params: Params, arch: Architecture, z: Any, cos_i: Any) -> tuple[Any, Any]:
    """Return the proposal's weights (..., K+1), the last the cosine lobe's, and widths (..., K).

    z (..., 32) and cos_i (...), the cosine of wi to the normal, broadcast against each other.
    Weights are positive and add up to 1; widths are GGX alphas in [0.01, 1].
    """
    first = split_linear(params, "sampler.0", z, sampler_features(cos_i))
    output = hidden_to_output(params, "sampler", first, arch.activation)
    xp = output.__array_namespace__()
    k = arch.lobes
    logits = output[..., : k + 1]
    shares = xp.exp(logits - xp.max(logits, axis=-1, keepdims=True))
    shares = shares * ((1.0 - MIN_COSINE_SHARE) / xp.sum(shares, axis=-1, keepdims=True))
    weights = xp.concat([shares[..., :k], shares[..., k:] + MIN_COSINE_SHARE], axis=-1)
    # A logistic function by tanh, which cannot overflow; geometric between 1 and MIN_ALPHA.
    fraction = 0.5 - 0.5 * xp.tanh(0.5 * output[..., k + 1 :])
    alphas = xp.clip(xp.exp(_LOG_MIN_ALPHA * fraction), MIN_ALPHA, 1.0)
    return weights, alphas
