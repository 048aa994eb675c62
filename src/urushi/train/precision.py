"""The precision of the large matrix products in training."""

from typing import Any

import jax.numpy as jnp

from urushi.nets.architecture import Params


def lowered(params: Params, precision: str) -> dict[str, Any]:
    """Parameters with which a loss is evaluated: as they are, or hidden matrices in bfloat16.

    Their products are then of bfloat16 factors. The first and the last layer of every network stay
    in float32, for a feature or an output with 8 bits would be wrong by half a per cent; so do all
    biases, activations, and the parameters that the optimiser keeps.
    """
    if precision == "float32":
        return dict(params)
    layers = [name.split(".") for name in params if name.endswith(".weight")]
    last = {net: max(int(k) for other, k, _ in layers if other == net) for net, _, _ in layers}
    hidden = {f"{net}.{k}.weight" for net, k, _ in layers if 0 < int(k) < last[net]}
    return {
        name: value.astype(jnp.bfloat16) if name in hidden else value
        for name, value in params.items()
    }
