"""Layering: coating a material in the latent space."""

from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.errors import ParameterError
from urushi.material.encode import encode
from urushi.material.material import Material
from urushi.material.texture import layer_texels
from urushi.nets.shipped import Weights
from urushi.reference.stack import Dielectric


def layer(
    top: Dielectric,
    bottom: Any,
    *,
    albedo: npt.ArrayLike = 0.0,
    sigma_t: npt.ArrayLike = 0.0,
    g: npt.ArrayLike = 0.0,
    model: Weights | None = None,
) -> Material:
    """Coat a material with a rough dielectric over a homogeneous medium of unit thickness.

    Args:
        top: the coat's interface, from `urushi.dielectric(alpha, eta)`.
        bottom: a Material, or anything that `encode` takes; coats nest.
        albedo: single-scattering albedo of the medium in [0, 1].
        sigma_t: its optical depth, >= 0.
        g: its Henyey-Greenstein asymmetry in (-1, 1).
        model: the networks if bottom is not a Material, as of `encode`.
            Every parameter is a scalar or one value per RGB channel.

    Returns:
        A Material of the bottom's channels, or of three if the bottom has one and a parameter has
        three.

    Raises:
        ParameterError: top is no dielectric, or a parameter is out of range or of a wrong shape.
    """
    if not isinstance(top, Dielectric):
        raise ParameterError(
            f"the top of a layering is a {type(top).__name__}; give the coat's interface, "
            "urushi.dielectric(alpha, eta)"
        )
    if not isinstance(bottom, Material) or model is not None:
        bottom = encode(bottom, model)
    parameters = {
        "alpha": np.asarray(top.alpha),
        "eta": np.asarray(top.eta),
        "albedo": checks.albedo(albedo, "the coat's albedo"),
        "sigma_t": checks.sigma_t(sigma_t, "the coat's sigma_t"),
        "g": checks.g(g, "the coat's g"),
    }
    if bottom.channels not in (1, 3):
        name = next((name for name, value in parameters.items() if value.ndim), None)
        if name:
            raise ParameterError(
                f"the coat's {name} has three values, but the bottom has {bottom.channels} "
                "channels; give a scalar"
            )
    return Material(layer_texels(bottom.model, bottom.anchors, **parameters), bottom.model)
