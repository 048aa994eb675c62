"""Latent textures: codes (..., 32) of many texels at once, in bounded memory.

A latent texture is a float32 array (H, W, C, 32); filtering and mip maps are linear in it. The
functions take any leading shape.
"""

import functools

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.errors import ParameterError
from urushi.material.cores import fill
from urushi.material.energy import limit, limit_coated
from urushi.nets.networks import Coat
from urushi.nets.weights import Model


def encode_texels(model: Model, f: np.ndarray) -> np.ndarray:
    """Return codes float32 (..., 32) from f (..., P) [1/sr] at the pairs of `model.networks`.

    Their directional albedo is at most 1 (see `urushi.material.energy`).
    """
    return limit(model, encoded(model, f))


def encoded(model: Model, f: np.ndarray) -> np.ndarray:
    """What the networks make of values f (..., P) [1/sr]: codes (..., 32) of any albedo."""
    values = np.asarray(f, np.float32)
    pairs = len(model.networks.pairs()[0])
    if not values.ndim or values.shape[-1] != pairs:
        raise ParameterError(f"f has shape {values.shape}; these networks need (..., {pairs})")
    codes = np.empty((*values.shape[:-1], model.arch.latent), np.float32)
    fill(codes, model.networks.encode, values, concurrent=model.networks.concurrent)
    return codes


def layer_texels(
    model: Model,
    z_bottom: np.ndarray,
    *,
    alpha: npt.ArrayLike,
    eta: npt.ArrayLike,
    albedo: npt.ArrayLike,
    sigma_t: npt.ArrayLike,
    g: npt.ArrayLike,
) -> np.ndarray:
    """Coat many texels by the layering network.

    Args:
        model: the networks.
        z_bottom: codes (..., 32) of the bottoms.
        alpha, eta: of the coat's interface; albedo, sigma_t, g: of the medium below it. Arrays
            that broadcast against each other and against z_bottom's leading shape, e.g. (H, W, 3).

    Returns:
        float32 (..., 32), of the shape that all of them broadcast to. Their directional albedo is
        at most 1, or that of the bottom if it gains energy (see `urushi.material.energy`).

    Raises:
        ParameterError: a parameter is out of range, or the shapes do not broadcast.
    """
    parameters = {
        name: getattr(checks, name)(value, f"the coat's {name}", any_shape=True)
        for name, value in (
            ("alpha", alpha), ("eta", eta), ("albedo", albedo), ("sigma_t", sigma_t), ("g", g)
        )
    }  # fmt: skip
    z = np.asarray(z_bottom, np.float32)
    try:
        shape = np.broadcast_shapes(z.shape[:-1], *(p.shape for p in parameters.values()))
    except ValueError as error:
        shapes = ", ".join(f"{name} {p.shape}" for name, p in parameters.items())
        raise ParameterError(
            f"the coat's parameters ({shapes}) do not fit the bottom's {z.shape[:-1]}; "
            "give scalars or arrays of the same shape"
        ) from error
    dielectrics = functools.partial(_dielectrics, model)
    rows = shape or (1,)
    coated = np.empty((*rows, z.shape[-1]), np.float32)
    fill(
        coated,
        lambda z, *p: model.networks.layer(z, Coat(*p), dielectrics),
        _leading(z, len(rows) + 1),
        *(_leading(p.astype(np.float32), len(rows)) for p in parameters.values()),
        concurrent=model.networks.concurrent,
    )
    return limit_coated(model, coated.reshape(*shape, z.shape[-1]), z)


def _leading(array: np.ndarray, dimensions: int) -> np.ndarray:
    """The array with as many dimensions, those of one before its own."""
    return array.reshape((1,) * (dimensions - array.ndim) + array.shape)


def _dielectrics(model: Model, alpha: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Values (S, P) [1/sr] of rough dielectrics' reflection at the pairs of `model.networks`."""
    from urushi.reference import evaluate  # lazily: it starts Dr.Jit

    wi, wo = model.networks.pairs()
    count = len(alpha)
    row = np.repeat(np.arange(count, dtype=np.uint32), len(wi))
    columns = {"alpha": alpha, "eta": eta}
    f = evaluate.rows("dielectric", columns, row, np.tile(wi, (count, 1)), np.tile(wo, (count, 1)))
    return f.reshape(count, -1)
