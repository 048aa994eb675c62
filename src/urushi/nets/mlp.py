"""The multilayer perceptron that all four networks are."""

from typing import Any

from urushi.nets.activation import activate
from urushi.nets.architecture import Params


def mlp(params: Params, prefix: str, x: Any, activation: str) -> Any:
    """Evaluate the network called `prefix` on x (..., in); returns (..., out).

    Every layer but the last is followed by the activation.
    """
    return hidden_to_output(params, prefix, linear(params, f"{prefix}.0", x), activation)


def linear(params: Params, name: str, x: Any) -> Any:
    """Return x (..., in) times the layer's weight (in, out) plus its bias."""
    result = product(x, params[f"{name}.weight"])
    result += params[f"{name}.bias"]  # in place where arrays can be changed
    return result


def split_linear(params: Params, name: str, x: Any, y: Any) -> Any:
    """Return `linear` of x and y concatenated, without concatenating them.

    x (..., a) and y (..., b) broadcast against each other, so that one latent code meets many
    directions at the cost of one product; the weight's first a rows belong to x.
    """
    weight = params[f"{name}.weight"]
    rows = x.shape[-1]
    from_x = product(x, weight[:rows, :]) + params[f"{name}.bias"]
    return from_x + product(y, weight[rows:, :])


def product(x: Any, weight: Any) -> Any:
    """Return x (..., in) times weight (in, out) as one large product of two matrices.

    NumPy would make many small ones of a stack, whose threads cost it up to thirty times as long.
    A weight of two bytes a number, which training may use, has x rounded to its type as well.
    """
    rows = x if x.ndim == 2 else x.reshape((-1, x.shape[-1]))
    if weight.dtype.itemsize == 2:
        xp = x.__array_namespace__()
        result = xp.astype(xp.astype(rows, weight.dtype) @ weight, x.dtype)
    else:
        result = rows @ weight
    return result if x.ndim == 2 else result.reshape((*x.shape[:-1], weight.shape[-1]))


def hidden_to_output(params: Params, prefix: str, first: Any, activation: str) -> Any:
    """Carry the first layer's pre-activation (..., width) through the rest of the network."""
    index = 1
    x = first
    while f"{prefix}.{index}.weight" in params:
        x = linear(params, f"{prefix}.{index}", activate(x, activation))
        index += 1
    return x
