"""Derivatives of networks by one backward pass each: what fitting codes to values needs."""

from typing import Any

from urushi.nets.activation import with_slope
from urushi.nets.architecture import SCALE, Architecture, Params
from urushi.nets.decoder import MAX_LOG, MIN_LOG, first_layer
from urushi.nets.encoder import normalised
from urushi.nets.mlp import linear, product


def decode_log(params: Params, arch: Architecture, z: Any, features: Any) -> tuple[Any, Any]:
    """Return ln f (...) of `decoder.decode` and its gradients (..., 32) with respect to z.

    z (..., 32) and features (..., 8) broadcast: z (S, 1, 32) with features (P, 8) gives (S, P).
    Each value depends on its own code alone, so the gradients are the Jacobian. They are zero
    where ln f is held at its least or greatest.
    """
    first = first_layer(params, z[..., 1:], features)
    output, gradient = _outputs(params, "decoder", first, arch.activation)
    xp = output.__array_namespace__()
    of_first = gradient[..., 0, :]
    weight, codes = params["decoder.0.weight"], arch.latent - 1
    scaled = product(of_first * product(features, weight[codes:, :]), params[SCALE].T)
    inner = scaled + product(of_first, weight[:codes, :].T)
    gain = xp.ones_like(inner[..., :1])
    value = z[..., 0] + output[..., 0]
    held = (value > MIN_LOG) & (value < MAX_LOG)
    slope = xp.where(held[..., None], xp.concat([gain, inner], axis=-1), 0.0)
    return value.clip(MIN_LOG, MAX_LOG), slope


def encode_log(params: Params, arch: Architecture, logs: Any) -> tuple[Any, Any]:
    """Return the codes z (..., 32) of `encoder.encode`, and their Jacobians (..., 32, P).

    logs (..., P): `encoder.log_values` of f at the probe pairs, which the Jacobians refer to.
    """
    first = linear(params, "encoder.0", normalised(params, logs))
    z, gradient = _outputs(params, "encoder", first, arch.activation)
    return z, product(gradient, params["encoder.0.weight"].T) / params["encoder.input_scale"]


def _outputs(params: Params, prefix: str, first: Any, activation: str) -> tuple[Any, Any]:
    """Outputs (..., out) from the first layer's pre-activation (..., width), and their gradients.

    The gradients (..., out, width) are with respect to the pre-activation.
    """
    slopes, index, x = [], 1, first
    while f"{prefix}.{index}.weight" in params:
        x, rise = with_slope(x, activation)
        slopes.append(rise)
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    last = params[f"{prefix}.{index - 1}.weight"].T  # (out, width)
    gradient = last * slopes.pop()[..., None, :]
    while slopes:
        index -= 1
        gradient = product(gradient, params[f"{prefix}.{index - 1}.weight"].T)
        gradient = gradient * slopes.pop()[..., None, :]
    return x, gradient
