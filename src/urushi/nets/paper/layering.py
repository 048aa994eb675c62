"""The paper's layering network: from two latent codes and a medium to the coated code."""

from typing import Any

import numpy as np

from urushi.nets.architecture import Params
from urushi.nets.paper import blocks
from urushi.nets.paper.architecture import LAYERING


def layer(params: Params, z_top: Any, z_bottom: Any, albedo: Any, sigma_t: Any) -> Any:
    """Return codes (..., 32) of bottoms z_bottom (..., 32) under dielectrics z_top (..., 32).

    albedo, sigma_t (...): of the medium between them, which scatters isotropically. Leading
    dimensions broadcast. Codes are about 1, hence shifted by it on the way in and out.
    """
    xp = z_top.__array_namespace__()
    medium = xp.stack(xp.broadcast_arrays(albedo, sigma_t), axis=-1)
    parts = [z_top - 1, z_bottom - 1, medium]
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    x = xp.concat([xp.broadcast_to(p, (*shape, p.shape[-1])) for p in parts], axis=-1)
    return blocks.apply(params, LAYERING, x) + 1


def isotropic(albedo: Any, sigma_t: Any, g: Any) -> tuple[Any, Any]:
    """Return albedo and sigma_t of the isotropic medium that resembles one of asymmetry g.

    By similarity (van de Hulst 1980): absorption stays, scattering is reduced by 1 - g.
    """
    reduced = 1 - albedo * g
    return albedo * (1 - g) / reduced, sigma_t * reduced
