"""The layerer: maps the latent code of a bottom and a coat to the code of the coated BRDF."""

from typing import Any

from urushi.nets.architecture import Architecture
from urushi.nets.mlp import Params, hidden_to_output, split_linear


def layer(params: Params, arch: Architecture, z_bottom: Any, coat: Any) -> Any:
    """Return the latent codes (..., 32) of bottoms z_bottom (..., 32) under coats.

    coat: `features.coat_features` (..., 17). z_bottom and coat broadcast against each other.
    The network computes the change of the bottom's code. It is multiplied by the coat's presence,
    so that a vanishing coat leaves the bottom's code unchanged.
    """
    inputs, presence = coat[..., :-1], coat[..., -1:]
    first = split_linear(params, "layerer.0", z_bottom, inputs)
    change = hidden_to_output(params, "layerer", first, arch.activation)
    return z_bottom + presence * change
