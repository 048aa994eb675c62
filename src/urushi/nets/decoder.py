"""The decoder: maps a latent code and a pair of directions to the BRDF without its lobe.

Codes z (..., R) have the numbers of the rest only, not of the lobe (`nets.lobe`).
"""

from typing import Any

import numpy as np

from urushi.core.table import MAX_LOG, MIN_LOG
from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.mlp import (
    Params,
    activate,
    gradient_of_first,
    hidden_to_output,
    hidden_with_slopes,
    product,
)

#: Gain with which any code decodes to exp(`MIN_LOG`).
EMPTY_GAIN = -100.0


def decode(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Return f (...) [1/sr, no cosine] for z (..., R) and `direction_features` (..., 8).

    z and features broadcast: z (S, 1, R) with features (S, P, 8) gives f (S, P).
    The first number of a code is a logarithmic gain. It is no input of the network but is added
    to its output, so that it scales f exactly, see `scaled`.
    """
    first = first_layer(params, z[..., 1:], features)
    output = z[..., 0] + hidden_to_output(params, "decoder", first, arch.activation)[..., 0]
    xp = output.__array_namespace__()
    return xp.exp(output.clip(MIN_LOG, MAX_LOG))


def first_layer(params: Params, z: Any, features: Any) -> Any:
    """Return the first layer's pre-activation (..., width) from codes without gain (..., R - 1).

    Each neuron's response to the features is multiplied by one plus a linear function of the code,
    and a second linear function of the code is added. The code so shifts and sharpens the
    response, and few neurons suffice for lobes of any width. The response itself depends on the
    directions alone and is the same for all channels.
    """
    weight, codes = params["decoder.0.weight"], z.shape[-1]
    offset = product(z, weight[:codes, :]) + params["decoder.0.bias"]
    return offset + (1.0 + product(z, params[SCALE])) * product(features, weight[codes:, :])


def decode_log(params: Params, arch: Architecture, z: Any, features: Any) -> tuple[Any, Any]:
    """Return ln f (...) of `decode`, and its gradients (..., R) with respect to z.

    z (..., R) and features (..., 8) broadcast: z (S, 1, R) with features (P, 8) gives (S, P).
    Each value depends on its own code alone, so that the gradients are the Jacobian. They are zero
    where ln f is clamped, and cost about as much as the network.
    """
    codes, weight = arch.latent - arch.lobe - 1, params["decoder.0.weight"]
    first = first_layer(params, z[..., 1:], features)
    output, slopes = hidden_with_slopes(params, "decoder", first, arch.activation)
    value = z[..., 0] + output[..., 0]
    xp = value.__array_namespace__()
    last = params[f"decoder.{len(slopes)}.weight"][:, 0]
    gradient = gradient_of_first(params, "decoder", slopes, last)
    inner = product(gradient * product(features, weight[codes:, :]), params[SCALE].T)
    inner = inner + product(gradient, weight[:codes, :].T)
    gain = xp.ones_like(inner[..., :1])
    inside = (value > MIN_LOG) & (value < MAX_LOG)
    slope = xp.where(inside[..., None], xp.concat([gain, inner], axis=-1), 0.0)
    return value.clip(MIN_LOG, MAX_LOG), slope


def decode_all(params: Params, arch: Architecture, z: np.ndarray, features: np.ndarray) -> Any:
    """Return `decode` (S, P) of all codes z (S, R) at all of the same directions (P, D).

    The neurons come before the directions, and NumPy then adds and multiplies along rows of
    directions, not of a few neurons. A row of codes is best as short as fits a core's cache.
    """
    weight, codes = params["decoder.0.weight"], z.shape[-1] - 1
    offset = product(z[:, 1:], weight[:codes]) + params["decoder.0.bias"]
    factor = 1.0 + product(z[:, 1:], params[SCALE])
    x = factor[..., None] * (weight[codes:].T @ features.T)
    x += offset[..., None]
    index = 1
    while f"decoder.{index}.weight" in params:
        x = params[f"decoder.{index}.weight"].T @ activate(x, arch.activation)
        x += params[f"decoder.{index}.bias"][:, None]
        index += 1
    return np.exp(np.clip(x[:, 0] + z[:, :1], MIN_LOG, MAX_LOG))


def scaled(z: Any, factor: Any) -> Any:
    """Return the codes (..., R) of `factor` (...) > 0 times the BRDFs of z (..., R).

    The factor is the same for all directions, so that f stays reciprocal.
    """
    xp = z.__array_namespace__()
    gain = z[..., :1] + xp.log(factor)[..., None]
    return xp.concat([gain, xp.broadcast_to(z[..., 1:], (*gain.shape[:-1], z.shape[-1] - 1))], -1)
