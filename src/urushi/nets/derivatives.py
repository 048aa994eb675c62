"""Jacobians of decoder and encoder, by which codes are fitted to values.

A Jacobian costs about as much as the network for each output.
"""

from typing import Any

from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.decoder import MAX_LOG, MIN_LOG, first_layer
from urushi.nets.encoder import normalised
from urushi.nets.mlp import Params, linear, product, with_slope


def decode_log(params: Params, arch: Architecture, z: Any, features: Any) -> tuple[Any, Any]:
    """Return ln f (...) of `decoder.decode` and its gradients (..., R) with respect to z.

    z (..., R) and features (..., 8) broadcast: z (S, 1, R) with features (P, 8) gives (S, P).
    Each value depends on its own code alone, so that the gradients are the Jacobian. They are zero
    where ln f is clamped.
    """
    codes, weight = arch.latent - arch.lobe - 1, params["decoder.0.weight"]
    first = first_layer(params, z[..., 1:], features)
    output, slopes = _forward(params, "decoder", first, arch.activation)
    value = z[..., 0] + output[..., 0]
    xp = value.__array_namespace__()
    last = params[f"decoder.{len(slopes)}.weight"][:, 0]
    gradient = _backward(params, "decoder", slopes, last)
    inner = product(gradient * product(features, weight[codes:, :]), params[SCALE].T)
    inner = inner + product(gradient, weight[:codes, :].T)
    gain = xp.ones_like(inner[..., :1])
    inside = (value > MIN_LOG) & (value < MAX_LOG)
    slope = xp.where(inside[..., None], xp.concat([gain, inner], axis=-1), 0.0)
    return value.clip(MIN_LOG, MAX_LOG), slope


def encode_log(params: Params, arch: Architecture, logs: Any) -> tuple[Any, Any]:
    """Return the codes z (..., R) of `encoder.encode`, and their Jacobians (..., R, P).

    logs (..., P): `encoder.log_values` of f at the probe pairs. The Jacobians are with respect to
    logs.
    """
    first = linear(params, "encoder.0", normalised(params, logs))
    z, slopes = _forward(params, "encoder", first, arch.activation)
    last = params[f"encoder.{len(slopes)}.weight"].T  # (R, width)
    gradient = _backward(params, "encoder", [slope[..., None, :] for slope in slopes], last)
    return z, product(gradient, params["encoder.0.weight"].T) / params["encoder.input_scale"]


def _forward(params: Params, prefix: str, first: Any, activation: str) -> tuple[Any, list[Any]]:
    """`mlp.hidden_to_output` (..., out) of `first` (..., width), and the slopes of each layer."""
    x, slopes = first, list[Any]()
    while f"{prefix}.{len(slopes) + 1}.weight" in params:
        x, slope = with_slope(x, activation)
        slopes.append(slope)
        x = linear(params, f"{prefix}.{len(slopes)}", x)
    return x, slopes


def _backward(params: Params, prefix: str, slopes: list[Any], gradient: Any) -> Any:
    """The gradient (..., width) by `first` of `_forward`, from that by the last hidden layer."""
    for index in reversed(range(len(slopes))):
        gradient = gradient * slopes[index]
        if index > 0:
            gradient = product(gradient, params[f"{prefix}.{index}.weight"].T)
    return gradient
