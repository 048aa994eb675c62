"""The paper's evaluation network: from a latent code and a pair of directions to the value.

Unlike Urushi's decoder it sees plain coordinates: it is not reciprocal, knows of isotropy only what
it has learned, and its output may be negative.
"""

from typing import Any

from urushi.nets.architecture import Params
from urushi.nets.mlp import product, split_linear
from urushi.nets.paper import blocks
from urushi.nets.paper.architecture import DIRECTIONS, EVALUATION

#: The first layer, which is evaluated apart: one code meets many directions.
_FIRST = "evaluation.0"


def direction_inputs(wi: Any, wo: Any) -> Any:
    """The inputs (..., 6): view.xy, light.xy, view.z, light.z; wi is the view, wo the light."""
    xp = wi.__array_namespace__()
    wi, wo = xp.broadcast_arrays(wi, wo)
    return xp.concat([wi[..., :2], wo[..., :2], wi[..., 2:], wo[..., 2:]], axis=-1)


def evaluate(params: Params, z: Any, directions: Any) -> Any:
    """Return values (...) [1/sr], negative ones included.

    z (..., 32) and `direction_inputs` (..., 6) broadcast against each other.
    """
    first = split_linear(params, _FIRST, directions, z)
    return blocks.apply(params, EVALUATION[1:], first)[..., 0]


def value_and_gradient(params: Params, z: Any, directions: Any) -> tuple[Any, Any]:
    """Return values (...) and their gradients (..., 32) with respect to z, as of `evaluate`.

    Samples are independent, so one backward pass gives every sample's own gradient: the Jacobian.
    """
    first = split_linear(params, _FIRST, directions, z)
    xp = first.__array_namespace__()
    y, pull = blocks.pulled_back(params, EVALUATION[1:], first)
    weight = params[f"{_FIRST}.weight"][DIRECTIONS:, :]
    return y[..., 0], product(pull(xp.ones_like(y)), weight.T)
