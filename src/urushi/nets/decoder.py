"""The decoder: from a latent code and a pair of directions to the BRDF's value."""

from typing import Any

from urushi.nets.architecture import Architecture, Params
from urushi.nets.mlp import hidden_to_output, split_linear

#: ln f is held within these, so that f is positive and finite whatever the weights.
MIN_LOG, MAX_LOG = -25.0, 20.0


def decode(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Return f (...) [1/sr, no cosine] for z (..., 32) and `direction_features` (..., 8).

    z and features broadcast: z (S, 1, 32) with features (S, P, 8) gives f (S, P).
    The first number of a code is a logarithmic gain that is added to the network's output and is
    none of its inputs: it scales f exactly, see `scaled`. The first layer's rows 0..30 belong to
    the others, the last 8 to the features, so that a renderer may store a texel's share of the
    first layer in place of z.
    """
    first = split_linear(params, "decoder.0", z[..., 1:], features)
    output = z[..., 0] + hidden_to_output(params, "decoder", first, arch.activation)[..., 0]
    xp = output.__array_namespace__()
    return xp.exp(xp.clip(output, MIN_LOG, MAX_LOG))


def scaled(z: Any, factor: Any) -> Any:
    """Return the codes (..., 32) whose f is `factor` (...) > 0 times that of z, for all directions.

    One factor for all pairs of directions keeps f reciprocal.
    """
    xp = z.__array_namespace__()
    gain = z[..., :1] + xp.log(factor)[..., None]
    return xp.concat([gain, xp.broadcast_to(z[..., 1:], (*gain.shape[:-1], z.shape[-1] - 1))], -1)
