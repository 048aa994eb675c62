"""Derivatives of networks by one backward pass each: what fitting codes to values needs.

Derivatives of encoder and layerer along directions, forward and backward.

A pushforward multiplies a change of the inputs with the Jacobian, a pullback a change of the
outputs' weights with its transpose: both cost about as much as the network itself, whereas the
Jacobians of `jacobian` cost as many times that as there are outputs. All arrays have rows (N, ...).
"""

from typing import Any

import numpy as np

from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.decoder import MAX_LOG, MIN_LOG, first_layer
from urushi.nets.encoder import OFFSET, log_values, normalised
from urushi.nets.features import coat_features
from urushi.nets.mlp import Params, hidden_to_output, linear, product, split_linear, with_slope


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


#: The derivative with respect to albedo is taken at most this close to 1, where it is infinite for
#: media that are infinitely deep.
LEAST_ABSORPTION = 1e-4

#: Step along the imaginary axis: no difference is formed, so that it may be as small as one likes
#: (Squire and Trapp 1998).
_STEP = 1e-20


def encode_pushforward(params: Params, arch: Architecture, f: Any, df: Any) -> Any:
    """Return the change (N, 32) of `encoder.encode`'s codes of f (N, P) for a change df (N, P)."""
    first, factor = _encoder_first(params, f)
    change = product(df * factor, params["encoder.0.weight"])
    return _pushforward(params, "encoder", first, change, arch.activation)


def encode_pullback(params: Params, arch: Architecture, f: Any, dz: Any) -> Any:
    """Return the gradient (N, P) with respect to f (N, P) of sums weighted by dz (N, 32)."""
    first, factor = _encoder_first(params, f)
    gradient = _pullback(params, "encoder", first, dz, arch.activation)
    return product(gradient, params["encoder.0.weight"].T) * factor


def layer_pushforward(
    params: Params, arch: Architecture, z: Any, coat: Any, dz: Any, dcoat: Any
) -> Any:
    """Return the change (N, 32) of `layerer.layer`'s codes.

    z (N, 32): the bottoms' codes; coat (N, 5): alpha, eta, albedo, sigma_t, g; dz, dcoat: their
    changes.
    """
    features, slopes = coat_slopes(coat)
    change = (slopes @ dcoat[..., None])[..., 0]
    weight, rows = params["layerer.0.weight"], z.shape[-1]
    first = split_linear(params, "layerer.0", z, features[:, :-1])
    dfirst = product(dz, weight[:rows]) + product(change[:, :-1], weight[rows:])
    output = hidden_to_output(params, "layerer", first, arch.activation)
    doutput = _pushforward(params, "layerer", first, dfirst, arch.activation)
    return dz + features[:, -1:] * doutput + change[:, -1:] * output


def layer_pullback(
    params: Params, arch: Architecture, z: Any, coat: Any, dz: Any
) -> tuple[Any, Any]:
    """Return gradients (N, 32) and (N, 5) with respect to the bottoms' codes and the coats.

    Of sums of the coated codes weighted by dz (N, 32); z and coat as in `layer_pushforward`.
    """
    features, slopes = coat_slopes(coat)
    weight, rows = params["layerer.0.weight"], z.shape[-1]
    first = split_linear(params, "layerer.0", z, features[:, :-1])
    output = hidden_to_output(params, "layerer", first, arch.activation)
    dfirst = _pullback(params, "layerer", first, features[:, -1:] * dz, arch.activation)
    dinputs = product(dfirst, weight[rows:].T)
    dpresence = (output * dz).sum(axis=-1, keepdims=True)
    dfeatures = np.concatenate([dinputs, dpresence], axis=-1)
    return dz + product(dfirst, weight[:rows].T), (dfeatures[:, None] @ slopes)[:, 0]


def coat_slopes(coat: Any) -> tuple[Any, Any]:
    """Return `features.coat_features` (N, 17) of coats (N, 5), and their derivatives (N, 17, 5)."""
    columns = list(coat.astype(np.float64).T)
    features = coat_features(*columns).astype(coat.dtype)
    columns[2] = np.minimum(columns[2], 1 - LEAST_ABSORPTION)
    slopes = np.empty((*features.shape, len(columns)), coat.dtype)
    for index, column in enumerate(columns):
        stepped = [*columns[:index], column + _STEP * 1j, *columns[index + 1 :]]
        slopes[..., index] = coat_features(*stepped).imag / _STEP
    return features, slopes


def _encoder_first(params: Params, f: Any) -> tuple[Any, Any]:
    """The encoder's first pre-activation (N, width), and d input / d f (N, P)."""
    inputs = normalised(params, log_values(f))
    factor = np.where(f >= 0, 1 / ((np.maximum(f, 0) + OFFSET) * params["encoder.input_scale"]), 0)
    return linear(params, "encoder.0", inputs), factor.astype(f.dtype)


def _pushforward(params: Params, prefix: str, first: Any, dfirst: Any, activation: str) -> Any:
    """The change (N, out) of `mlp.hidden_to_output` for one of the pre-activation (N, width)."""
    index, x, dx = 1, first, dfirst
    while f"{prefix}.{index}.weight" in params:
        x, rise = with_slope(x, activation)
        dx = product(rise * dx, params[f"{prefix}.{index}.weight"])
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    return dx


def _pullback(params: Params, prefix: str, first: Any, doutput: Any, activation: str) -> Any:
    """The gradient (N, width) with respect to the pre-activation, given that of outputs."""
    slopes, index, x = [], 1, first
    while f"{prefix}.{index}.weight" in params:
        x, rise = with_slope(x, activation)
        slopes.append(rise)
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    gradient = doutput
    while slopes:
        index -= 1
        gradient = product(gradient, params[f"{prefix}.{index}.weight"].T) * slopes.pop()
    return gradient
