"""The encoder: from a BRDF's values at the fixed probe pairs to its latent code."""

from typing import Any

import numpy as np

from urushi.nets.architecture import Architecture
from urushi.nets.mlp import Params, mlp

#: Added to f before the logarithm: values far below it [1/sr] look alike to the encoder.
OFFSET = 1e-4


def log_values(f: Any) -> Any:
    """Return ln(f + `OFFSET`); negative f, which only a faulty callable gives, counts as 0."""
    xp = f.__array_namespace__()
    return xp.log(xp.maximum(f, 0.0) + OFFSET)


def input_statistics(f: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fixed parameters that normalise the inputs, from f (materials, probes).

    The scale is at least 0.1, lest a probe that is nearly constant over the data blow up noise.
    """
    values = log_values(np.asarray(f, np.float64))
    return {
        "encoder.input_mean": values.mean(axis=0).astype(np.float32),
        "encoder.input_scale": np.maximum(values.std(axis=0), 0.1).astype(np.float32),
    }


def encode(params: Params, arch: Architecture, f_at_probes: Any) -> Any:
    """Return latent codes z (..., 32) from f (..., probes) [1/sr] at `probes.probe_pairs`."""
    return mlp(params, "encoder", normalised(params, log_values(f_at_probes)), arch.activation)


def of_fewer(params: Params, kept: np.ndarray, matrix: np.ndarray, offset: np.ndarray) -> Params:
    """Return the parameters of an encoder that takes f (..., K) at some of the probe pairs.

    kept (K,): which; matrix (K, P), offset (P,): what tells the inputs of all from those of these.
    """
    weight, bias = params["encoder.0.weight"], params["encoder.0.bias"]
    return {
        **params,
        "encoder.0.weight": matrix @ weight,
        "encoder.0.bias": bias + offset @ weight,
        "encoder.input_mean": params["encoder.input_mean"][kept],
        "encoder.input_scale": params["encoder.input_scale"][kept],
    }


def normalised(params: Params, logs: Any) -> Any:
    """Return the network's inputs (..., probes) from `log_values`: about mean 0 and variance 1."""
    return (logs - params["encoder.input_mean"]) / params["encoder.input_scale"]
