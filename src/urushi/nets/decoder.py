"""The decoder: from a latent code and a pair of directions to the BRDF's value."""

from typing import Any

from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.mlp import Params, hidden_to_output, product

#: ln f is held within these, so that f is positive and finite whatever the weights.
MIN_LOG, MAX_LOG = -25.0, 20.0


def decode(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Return f (...) [1/sr, no cosine] for z (..., 32) and `direction_features` (..., 8).

    z and features broadcast: z (S, 1, 32) with features (S, P, 8) gives f (S, P).
    The first number of a code is a logarithmic gain that is added to the network's output and is
    none of its inputs: it scales f exactly, see `scaled`.
    """
    first = first_layer(params, z[..., 1:], features)
    output = z[..., 0] + hidden_to_output(params, "decoder", first, arch.activation)[..., 0]
    xp = output.__array_namespace__()
    return xp.exp(output.clip(MIN_LOG, MAX_LOG))


def first_layer(params: Params, z: Any, features: Any) -> Any:
    """Return the first layer's pre-activation (..., width) from codes without gain (..., 31).

    Every neuron's response to the features is multiplied by one plus a share of the code, which
    moves and sharpens it, and another share is added: lobes of any width need few neurons. Only
    the response itself depends on the directions, and it is the same for all channels.
    """
    weight, codes = params["decoder.0.weight"], z.shape[-1]
    offset = product(z, weight[:codes, :]) + params["decoder.0.bias"]
    return offset + (1.0 + product(z, params[SCALE])) * product(features, weight[codes:, :])


def scaled(z: Any, factor: Any) -> Any:
    """Return the codes (..., 32) whose f is `factor` (...) > 0 times that of z, for all directions.

    One factor for all pairs of directions keeps f reciprocal.
    """
    xp = z.__array_namespace__()
    gain = z[..., :1] + xp.log(factor)[..., None]
    return xp.concat([gain, xp.broadcast_to(z[..., 1:], (*gain.shape[:-1], z.shape[-1] - 1))], -1)
