"""The paper's evaluation and layering networks: codes and directions to f, coats to codes.

Unlike Urushi's decoder, the evaluation network takes the coordinates of the directions. It is not
reciprocal, it is isotropic only as far as it has learnt to be, and its output may be negative.
"""

from typing import Any

import numpy as np

from urushi.fan2022 import blocks
from urushi.fan2022.architecture import DIRECTIONS, EVALUATION, LAYERING
from urushi.nets.mlp import Params, product, split_linear

#: The first layer; its product with the code is shared by all directions.
_FIRST = "evaluation.0"

#: Place of the light's cosine among the direction inputs.
LIGHT_COSINE = 5


def direction_inputs(wi: Any, wo: Any) -> Any:
    """The direction inputs (..., 6): wi.xy, wo.xy, wi.z, wo.z; wi is the view, wo the light."""
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
    """Return `evaluate`'s values (...) and their gradients (..., 32) with respect to z.

    The values are independent of each other, so one backward pass gives all gradients.
    """
    first = split_linear(params, _FIRST, directions, z)
    xp = first.__array_namespace__()
    y, pull = blocks.pulled_back(params, EVALUATION[1:], first)
    weight = params[f"{_FIRST}.weight"][DIRECTIONS:, :]
    return y[..., 0], product(pull(xp.ones_like(y)), weight.T)


def layer(params: Params, z_top: Any, z_bottom: Any, albedo: Any, sigma_t: Any) -> Any:
    """Return codes (..., 32) of bottoms z_bottom (..., 32) under dielectrics z_top (..., 32).

    albedo, sigma_t (...): of the medium between them, which scatters isotropically. Leading
    dimensions broadcast. Codes are close to 1, so the network reads and returns codes minus 1.
    """
    xp = z_top.__array_namespace__()
    medium = xp.stack(xp.broadcast_arrays(albedo, sigma_t), axis=-1)
    parts = [z_top - 1, z_bottom - 1, medium]
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    x = xp.concat([xp.broadcast_to(p, (*shape, p.shape[-1])) for p in parts], axis=-1)
    return blocks.apply(params, LAYERING, x) + 1


def isotropic(albedo: Any, sigma_t: Any, g: Any) -> tuple[Any, Any]:
    """Return albedo and sigma_t of the isotropic medium similar to a medium of asymmetry g.

    Similarity relation (van de Hulst 1980): equal absorption, scattering times 1 - g.
    """
    reduced = 1 - albedo * g
    return albedo * (1 - g) / reduced, sigma_t * reduced
