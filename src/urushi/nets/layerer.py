"""The layering network: from a bottom's latent code and a coat to the coated latent code."""

from typing import Any

from urushi.nets.architecture import Architecture
from urushi.nets.mlp import Params, hidden_to_output, split_linear


def layer(params: Params, arch: Architecture, z_bottom: Any, coat: Any) -> Any:
    """Return the latent codes (..., 32) of bottoms z_bottom (..., 32) under coats.

    coat: `features.coat_features` (..., 17); both broadcast against each other. The network gives
    the difference to the bottom's code, which is multiplied by the coat's presence, so that a
    vanishing coat leaves the bottom itself.
    """
    inputs, presence = coat[..., :-1], coat[..., -1:]
    first = split_linear(params, "layerer.0", z_bottom, inputs)
    change = hidden_to_output(params, "layerer", first, arch.activation)
    return z_bottom + presence * change
