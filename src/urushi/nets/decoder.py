"""The decoder: from a latent code and a pair of directions to the BRDF's value."""

from typing import Any

from urushi.nets.architecture import Architecture, Params
from urushi.nets.mlp import hidden_to_output, split_linear

#: ln f is held within these, so that f is positive and finite whatever the weights.
MIN_LOG, MAX_LOG = -25.0, 20.0


def decode(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Return f (...) [1/sr, no cosine] for z (..., 32) and `direction_features` (..., 8).

    z and features broadcast: z (S, 1, 32) with features (S, P, 8) gives f (S, P).
    The first layer's rows 0..31 belong to z, the last 8 to the features, so that a renderer may
    store a texel's `z @ weight[:32] + bias` in place of z.
    """
    first = split_linear(params, "decoder.0", z, features)
    output = hidden_to_output(params, "decoder", first, arch.activation)[..., 0]
    xp = output.__array_namespace__()
    return xp.exp(xp.clip(output, MIN_LOG, MAX_LOG))
