"""The encoder: maps the values of a BRDF at the fixed probe pairs to its latent code.

The values are f minus the lobe (`nets.lobe`); the code has the numbers of the rest only.
"""

from typing import Any

import numpy as np

from urushi.nets.architecture import Architecture
from urushi.nets.mlp import Params, gradient_of_first, hidden_with_slopes, linear, mlp, product

#: [1/sr] Added to f before the logarithm; differences between values far below it are ignored.
OFFSET = 1e-4


def log_values(f: Any) -> Any:
    """Return ln(f + `OFFSET`). Negative f, which only a faulty BRDF has, counts as 0."""
    xp = f.__array_namespace__()
    return xp.log(xp.maximum(f, 0.0) + OFFSET)


def input_statistics(f: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fixed parameters that normalise the inputs, from f (materials, probes).

    The scale is at least 0.1: a smaller one, of a probe that is nearly constant over the data,
    would amplify noise.
    """
    values = log_values(np.asarray(f, np.float64))
    return {
        "encoder.input_mean": values.mean(axis=0).astype(np.float32),
        "encoder.input_scale": np.maximum(values.std(axis=0), 0.1).astype(np.float32),
    }


def encode(params: Params, arch: Architecture, f_at_probes: Any) -> Any:
    """Return latent codes z (..., R) from f (..., probes) [1/sr] at `probe_pairs`."""
    return mlp(params, "encoder", normalised(params, log_values(f_at_probes)), arch.activation)


def encode_log(params: Params, arch: Architecture, logs: Any) -> tuple[Any, Any]:
    """Return the codes z (..., R) of `encode`, and their Jacobians (..., R, P) by `logs`.

    logs: (..., P) `log_values` of f at the probe pairs. A Jacobian costs about R networks.
    """
    first = linear(params, "encoder.0", normalised(params, logs))
    z, slopes = hidden_with_slopes(params, "encoder", first, arch.activation)
    last = params[f"encoder.{len(slopes)}.weight"].T  # (R, width)
    rows = [slope[..., None, :] for slope in slopes]
    gradient = gradient_of_first(params, "encoder", rows, last)
    return z, product(gradient, params["encoder.0.weight"].T) / params["encoder.input_scale"]


def normalised(params: Params, logs: Any) -> Any:
    """Return the network's inputs (..., probes) from `log_values`, of mean 0 and variance 1."""
    return (logs - params["encoder.input_mean"]) / params["encoder.input_scale"]
