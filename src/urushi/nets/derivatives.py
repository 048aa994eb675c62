"""Derivatives of the networks in NumPy, without automatic differentiation.

`decode_log` and `encode_log` return values and whole Jacobians; fitting codes to values needs
them. A pushforward multiplies a change of the inputs by the Jacobian, a pullback multiplies weights
of the outputs by its transpose. These two cost about as much as the network itself; a Jacobian
costs that much for each output.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.architecture import SCALE, Architecture
from urushi.nets.decoder import MAX_LOG, MIN_LOG, first_layer
from urushi.nets.encoder import OFFSET, log_values, normalised
from urushi.nets.features import coat_features
from urushi.nets.lobe import LOBE_FEATURES
from urushi.nets.lobe_fit_slopes import FITTED, fit_slopes
from urushi.nets.mlp import Params, linear, product, split_linear, with_slope

#: Least 1 - albedo at which the derivative with respect to albedo is taken: at albedo = 1 it is
#: infinite for infinitely deep media.
MIN_ABSORPTION = 1e-4

#: Step along the imaginary axis. No difference is formed, so that the step can be arbitrarily
#: small (Squire and Trapp 1998).
_STEP = 1e-20

#: Places of widths and index among the columns of a coat, and among the numbers of its lobe.
_OF_COAT = {1: ((0, 1), (0, 4)), 2: ((0, 1, 5), (0, 4, 6))}


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


def encode_pushforward(params: Params, arch: Architecture, rest: Any, drest: Any) -> Any:
    """Return the change (N, R) of the encoder's numbers for a change drest (N, P) of rest (N, P).

    rest: [1/sr] what the lobe leaves of f at the probe pairs.
    """
    first, factor = _encoder_first(params, rest)
    change = product(drest * factor, params["encoder.0.weight"])
    return _pushforward(params, "encoder", first, change, arch.activation)


def encode_pullback(params: Params, arch: Architecture, rest: Any, dz: Any) -> Any:
    """Return the gradient (N, P) by rest (N, P) of the sum of the numbers weighted by dz (N, R)."""
    first, factor = _encoder_first(params, rest)
    gradient = _pullback(params, "encoder", first, dz, arch.activation)
    return product(gradient, params["encoder.0.weight"].T) * factor


def lobe_pushforward(arch: Architecture, f: Any, df: Any, lobe: Any) -> Any:
    """Return the change (N, L) of lobes (N, L) fitted to f (N, P) for a change df (N, P)."""
    change = np.zeros(lobe.shape)
    change[:, FITTED[arch.widths]] = (fit_slopes(f, lobe, arch.widths) @ df[..., None])[..., 0]
    return change


def lobe_pullback(arch: Architecture, f: Any, dlobe: Any, lobe: Any) -> Any:
    """Return the gradient (N, P) by f of the sum of the lobes' numbers weighted by dlobe (N, L)."""
    return (dlobe[:, None, FITTED[arch.widths]] @ fit_slopes(f, lobe, arch.widths))[:, 0]


def top_slopes(arch: Architecture, lobe: Any) -> Any:
    """Derivatives (N, L, P) of f of lobes (N, L) at the probe pairs by their numbers."""
    wi, wo = probe_pairs(arch.probes, arch.widths)
    return np.stack(_by_numbers(lambda x: lobes.f(x[:, None], wi, wo), lobe), axis=1)


class _LayererInputs(NamedTuple):
    """Inputs of the layerer's network, and their derivatives.

    Attributes:
        own: (N, K) what it sees of the bottom; coat: (N, F) of the coat.
        of_bottom: (N, K, L) derivatives of `own` by the bottom's code.
        of_coat: (N, F, C) derivatives of `coat`.
    """

    own: Any
    coat: Any
    of_bottom: Any
    of_coat: Any


def _layerer_inputs(arch: Architecture, z: Any, coat: Any) -> _LayererInputs:
    features, slopes = coat_slopes(coat)
    rest = arch.latent - arch.lobe
    lobe_features, of_lobe = lobe_slopes(z[:, : arch.lobe])
    of_bottom = np.zeros((len(z), rest + LOBE_FEATURES[arch.widths], arch.latent), z.dtype)
    of_bottom[:, :rest, arch.lobe :] = np.eye(rest)
    of_bottom[:, rest:, : arch.lobe] = of_lobe
    own = np.concatenate([z[:, arch.lobe :], lobe_features], axis=-1)
    return _LayererInputs(own, features, of_bottom, slopes)


def layer_pushforward(
    params: Params, arch: Architecture, z: Any, coat: Any, dz: Any, dcoat: Any
) -> Any:
    """Return the change (N, L) of `layerer.layer` for changes of bottoms and coats.

    Args:
        params, arch: the networks.
        z: (N, L) codes of the bottoms.
        coat: (N, C) the columns `checks.COAT_COLUMNS` of the coats.
        dz, dcoat: changes of z and coat.
    """
    inputs = _layerer_inputs(arch, z, coat)
    down = (inputs.of_bottom @ dz[..., None])[..., 0]
    dcoat = dcoat[..., None]
    weight, rows = params["layerer.0.weight"], inputs.own.shape[-1]
    first = split_linear(params, "layerer.0", inputs.own, inputs.coat)
    dfirst = product(down, weight[:rows]) + product((inputs.of_coat @ dcoat)[..., 0], weight[rows:])
    change = _pushforward(params, "layerer", first, dfirst, arch.activation)
    change += dz[:, arch.lobe :]
    top = np.zeros_like(dz[:, : arch.lobe])
    columns, numbers = _OF_COAT[arch.widths]
    top[:, numbers] = dcoat[:, columns, 0]
    return np.concatenate([top, change], axis=-1)


def layer_pullback(
    params: Params, arch: Architecture, z: Any, coat: Any, dz: Any
) -> tuple[Any, Any]:
    """Return gradients (N, L) and (N, C) with respect to the bottoms' codes and the coats.

    They are the gradients of the sum of the coated codes weighted by dz (N, L). z and coat are
    those of `layer_pushforward`.
    """
    inputs = _layerer_inputs(arch, z, coat)
    weight, rows = params["layerer.0.weight"], inputs.own.shape[-1]
    first = split_linear(params, "layerer.0", inputs.own, inputs.coat)
    of_rest = dz[:, arch.lobe :]
    dfirst = _pullback(params, "layerer", first, of_rest, arch.activation)
    of_own, of_coat = product(dfirst, weight[:rows].T), product(dfirst, weight[rows:].T)
    of_coat = (of_coat[:, None] @ inputs.of_coat)[:, 0]
    of_bottom = (of_own[:, None] @ inputs.of_bottom)[:, 0]
    of_bottom[:, arch.lobe :] += of_rest
    columns, numbers = _OF_COAT[arch.widths]
    of_coat[:, columns] += dz[:, numbers]
    return of_bottom, of_coat


def coat_slopes(coat: Any) -> tuple[Any, Any]:
    """Return `features.coat_features` (N, F) of coats (N, C), and their derivatives (N, F, C)."""

    def features(coat: Any) -> Any:
        return coat_features(*CoatParameters.of_columns(coat.T))

    inside = coat.astype(np.float64)
    value = features(inside).astype(coat.dtype)
    inside[:, 2] = np.minimum(inside[:, 2], 1 - MIN_ABSORPTION)
    return value, np.stack(_by_numbers(features, inside), axis=-1).astype(coat.dtype)


def lobe_slopes(lobe: Any) -> tuple[Any, Any]:
    """Return `lobe.lobe_features` (N, F) of lobes (N, L), and their derivatives (N, F, L)."""
    numbers = lobe.astype(np.float64)
    slopes = np.stack(_by_numbers(lobes.lobe_features, numbers), axis=-1).astype(lobe.dtype)
    return lobes.lobe_features(numbers).astype(lobe.dtype), slopes


def _by_numbers(function: Callable[[Any], Any], x: Any) -> list[Any]:
    """The derivatives (N, ...) of function(x) by each of the K numbers of x (N, K)."""
    return [function(x + _STEP * 1j * step).imag / _STEP for step in np.eye(x.shape[-1])]


def _encoder_first(params: Params, f: Any) -> tuple[Any, Any]:
    """The encoder's first pre-activation (N, width), and the derivatives d input / d f (N, P)."""
    inputs = normalised(params, log_values(f))
    factor = np.where(f >= 0, 1 / ((np.maximum(f, 0) + OFFSET) * params["encoder.input_scale"]), 0)
    return linear(params, "encoder.0", inputs), factor.astype(f.dtype)


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


def _pushforward(params: Params, prefix: str, first: Any, dfirst: Any, activation: str) -> Any:
    """The change (N, out) of `mlp.hidden_to_output` for a change `dfirst` of `first` (N, width)."""
    change = dfirst
    for index, slope in enumerate(_forward(params, prefix, first, activation)[1], start=1):
        change = product(slope * change, params[f"{prefix}.{index}.weight"])
    return change


def _pullback(params: Params, prefix: str, first: Any, doutput: Any, activation: str) -> Any:
    """The gradient (N, width) with respect to `first`, given the outputs' weights (N, out)."""
    slopes = _forward(params, prefix, first, activation)[1]
    gradient = product(doutput, params[f"{prefix}.{len(slopes)}.weight"].T)
    return _backward(params, prefix, slopes, gradient)
