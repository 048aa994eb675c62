"""Multilayer perceptrons: layers and activations."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

#: Parameters by name, such as "layerer.0.weight"; arrays of NumPy or of JAX.
Params = Mapping[str, Any]

#: Activations x (1/2 + t q(t^2)) by name: (bound, coefficients of the polynomial q, lowest power
#: first). t is x clamped to [-bound, bound]. At the bounds the factor in parentheses is 0 or 1 and
#: its slope is 0. "smoothstep" is the simplest; "silu7" is within 0.02 of SiLU.
POLYNOMIALS = {
    "smoothstep": (2.0, (0.375, -0.03125)),
    "silu7": (5.75, (0.225729, -0.010473, 2.924521977775268e-4, -3.1043713096403e-6)),
}


def linear(params: Params, name: str, x: Any) -> Any:
    """Return x (..., in) times the layer's weight (in, out) plus its bias."""
    result = product(x, params[f"{name}.weight"])
    result += params[f"{name}.bias"]  # in place where arrays can be changed
    return result


def split_linear(params: Params, name: str, x: Any, y: Any) -> Any:
    """Return `linear` of x and y concatenated, without concatenating them.

    x (..., a) and y (..., b) broadcast against each other: one latent code is combined with many
    directions at the cost of one product. The first a rows of the weight belong to x.
    """
    weight = params[f"{name}.weight"]
    from_x = product(x, weight[: x.shape[-1]])
    from_x += params[f"{name}.bias"]  # in place where arrays can be changed
    return from_x + product(y, weight[x.shape[-1] :])


def product(x: Any, weight: Any) -> Any:
    """Return x (..., in) times weight (in, out) as one large product of two matrices.

    NumPy would multiply a stack of matrices one by one, which takes up to thirty times as long.
    """
    rows = x if x.ndim == 2 else x.reshape((-1, x.shape[-1]))
    result = rows @ weight
    return result if x.ndim == 2 else result.reshape((*x.shape[:-1], weight.shape[-1]))


def hidden_to_output(params: Params, prefix: str, first: Any, activation: str) -> Any:
    """Evaluate the rest of the network from the first layer's pre-activation (..., width).

    The activation follows every layer except the last.
    """
    index, x = 1, first
    while f"{prefix}.{index}.weight" in params:
        x = linear(params, f"{prefix}.{index}", activate(x, activation))
        index += 1
    return x


def activate(x: Any, activation: str) -> Any:
    """Apply an activation to each element.

    "relu" is the positive part. `POLYNOMIALS` resemble SiLU, x times its logistic function, without
    an exponential or a division, which makes rendering faster.
    """
    if activation == "relu":
        return x.__array_namespace__().maximum(x, 0.0)
    bound, (*others, last) = POLYNOMIALS[activation]
    t = x.clip(-bound, bound)
    u = t * t
    q = u * last
    for coefficient in reversed(others[1:]):  # in place where arrays can be changed
        q += coefficient
        q *= u
    q += others[0]
    q *= t
    q += 0.5
    q *= x
    return q


def shapes_of(prefix: str, sizes: Sequence[int]) -> dict[str, tuple[int, ...]]:
    """Shapes by name of the parameters of the network `prefix` with layers of these sizes."""
    shapes: dict[str, tuple[int, ...]] = {}
    for index, layer in enumerate(itertools.pairwise(sizes)):
        shapes |= {f"{prefix}.{index}.weight": layer, f"{prefix}.{index}.bias": layer[1:]}
    return shapes
