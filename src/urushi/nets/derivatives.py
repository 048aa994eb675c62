"""Derivatives of the networks in NumPy, without automatic differentiation.

`decode_log` and `encode_log` return values and whole Jacobians; fitting codes to values needs
them. A pushforward multiplies a change of the inputs by the Jacobian, a pullback multiplies weights
of the outputs by its transpose. These two cost about as much as the network itself, a Jacobian
costs that times the number of outputs.
"""

from typing import Any

import numpy as np

from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.decoder import MAX_LOG, MIN_LOG, first_layer
from urushi.nets.encoder import OFFSET, log_values, normalised
from urushi.nets.features import coat_features
from urushi.nets.mlp import Params, hidden_to_output, linear, product, split_linear, with_slope

#: Least 1 - albedo at which the derivative with respect to albedo is taken: at albedo = 1 it is
#: infinite for infinitely deep media.
MIN_ABSORPTION = 1e-4

#: Step along the imaginary axis. No difference is formed, so that the step can be arbitrarily
#: small (Squire and Trapp 1998).
_STEP = 1e-20


def decode_log(params: Params, arch: Architecture, z: Any, features: Any) -> tuple[Any, Any]:
    """Return ln f (...) of `decoder.decode` and its gradients (..., 32) with respect to z.

    z (..., 32) and features (..., 8) broadcast: z (S, 1, 32) with features (P, 8) gives (S, P).
    Each value depends on its own code alone, so that the gradients are the Jacobian. They are zero
    where ln f is clamped.
    """
    first = first_layer(params, z[..., 1:], features)
    output, gradient = _output_gradients(params, "decoder", first, arch.activation)
    xp = output.__array_namespace__()
    gradient = gradient[..., 0, :]
    weight, codes = params["decoder.0.weight"], arch.latent - arch.lobe - 1
    scaled = product(gradient * product(features, weight[codes:, :]), params[SCALE].T)
    inner = scaled + product(gradient, weight[:codes, :].T)
    gain = xp.ones_like(inner[..., :1])
    value = z[..., 0] + output[..., 0]
    inside = (value > MIN_LOG) & (value < MAX_LOG)
    slope = xp.where(inside[..., None], xp.concat([gain, inner], axis=-1), 0.0)
    return value.clip(MIN_LOG, MAX_LOG), slope


def encode_log(params: Params, arch: Architecture, logs: Any) -> tuple[Any, Any]:
    """Return the codes z (..., 32) of `encoder.encode`, and their Jacobians (..., 32, P).

    logs (..., P): `encoder.log_values` of f at the probe pairs. The Jacobians are with respect to
    logs.
    """
    first = linear(params, "encoder.0", normalised(params, logs))
    z, gradient = _output_gradients(params, "encoder", first, arch.activation)
    return z, product(gradient, params["encoder.0.weight"].T) / params["encoder.input_scale"]


def encode_pushforward(params: Params, arch: Architecture, f: Any, df: Any) -> Any:
    """Return the change (N, 32) of `encoder.encode` for a change df (N, P) of f (N, P)."""
    first, factor = _encoder_first(params, f)
    change = product(df * factor, params["encoder.0.weight"])
    return _pushforward(params, "encoder", first, change, arch.activation)


def encode_pullback(params: Params, arch: Architecture, f: Any, dz: Any) -> Any:
    """Return the gradient (N, P) by f (N, P) of the sum of the codes weighted by dz (N, 32)."""
    first, factor = _encoder_first(params, f)
    gradient = _pullback(params, "encoder", first, dz, arch.activation)
    return product(gradient, params["encoder.0.weight"].T) * factor


def layer_pushforward(
    params: Params, arch: Architecture, z: Any, coat: Any, dz: Any, dcoat: Any
) -> Any:
    """Return the change (N, 32) of `layerer.layer` for changes of bottoms and coats.

    Args:
        params, arch: the networks.
        z: (N, 32) codes of the bottoms.
        coat: (N, 5) alpha, eta, albedo, sigma_t, g.
        dz, dcoat: changes of z and coat.
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

    They are the gradients of the sum of the coated codes weighted by dz (N, 32). z and coat are
    those of `layer_pushforward`.
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
    """Return `features.coat_features` (N, 17) of coats (N, 5), and derivatives (N, 17, 5)."""
    columns = list(coat.astype(np.float64).T)
    features = coat_features(*columns).astype(coat.dtype)
    columns[2] = np.minimum(columns[2], 1 - MIN_ABSORPTION)
    slopes = np.empty((*features.shape, len(columns)), coat.dtype)
    for index, column in enumerate(columns):
        stepped = [*columns[:index], column + _STEP * 1j, *columns[index + 1 :]]
        slopes[..., index] = coat_features(*stepped).imag / _STEP
    return features, slopes


def _encoder_first(params: Params, f: Any) -> tuple[Any, Any]:
    """The encoder's first pre-activation (N, width), and the derivatives d input / d f (N, P)."""
    inputs = normalised(params, log_values(f))
    factor = np.where(f >= 0, 1 / ((np.maximum(f, 0) + OFFSET) * params["encoder.input_scale"]), 0)
    return linear(params, "encoder.0", inputs), factor.astype(f.dtype)


def _pushforward(params: Params, prefix: str, first: Any, dfirst: Any, activation: str) -> Any:
    """The change (N, out) of `mlp.hidden_to_output` for a change `dfirst` of `first` (N, width)."""
    index, x, dx = 1, first, dfirst
    while f"{prefix}.{index}.weight" in params:
        x, slope = with_slope(x, activation)
        dx = product(slope * dx, params[f"{prefix}.{index}.weight"])
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    return dx


def _pullback(params: Params, prefix: str, first: Any, doutput: Any, activation: str) -> Any:
    """The gradient (N, width) with respect to `first`, given the outputs' weights (N, out)."""
    slopes, index, x = [], 1, first
    while f"{prefix}.{index}.weight" in params:
        x, slope = with_slope(x, activation)
        slopes.append(slope)
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    gradient = doutput
    while slopes:
        index -= 1
        gradient = product(gradient, params[f"{prefix}.{index}.weight"].T) * slopes.pop()
    return gradient


def _output_gradients(params: Params, prefix: str, first: Any, activation: str) -> tuple[Any, Any]:
    """Outputs (..., out) of a network from its first layer's pre-activation (..., width).

    Also returns their gradients (..., out, width) with respect to the pre-activation.
    """
    slopes, index, x = [], 1, first
    while f"{prefix}.{index}.weight" in params:
        x, slope = with_slope(x, activation)
        slopes.append(slope)
        x = linear(params, f"{prefix}.{index}", x)
        index += 1
    last = params[f"{prefix}.{index - 1}.weight"].T  # (out, width)
    gradient = last * slopes.pop()[..., None, :]
    while slopes:
        index -= 1
        gradient = product(gradient, params[f"{prefix}.{index - 1}.weight"].T)
        gradient = gradient * slopes.pop()[..., None, :]
    return x, gradient
