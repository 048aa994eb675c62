"""The multilayer perceptron that all four networks are.

The activations of hidden layers, and their derivatives.
"""

from collections.abc import Mapping, Sequence
from typing import Any

#: Parameters by name, such as "decoder.0.weight"; arrays of NumPy or of JAX.
Params = Mapping[str, Any]

#: Activations x (1/2 + t q(t^2)), t being x held within plus and minus the first number; the others
#: are q's coefficients, lowest power first. There q has brought the bracket to 1, or 0, and its
#: slope to 0. "smoothstep" is the plainest; "silu7" is within 0.02 of SiLU.
POLYNOMIALS = {
    "smoothstep": (2.0, (0.375, -0.03125)),
    "silu7": (5.75, (0.225729, -0.010473, 2.924521977775268e-4, -3.1043713096403e-6)),
}


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


def activate(x: Any, activation: str) -> Any:
    """Apply an activation element by element.

    "relu" is the positive part, "silu" is x times its logistic function. `POLYNOMIALS` are like it
    without an exponential or a division, which makes a renderer faster.
    """
    xp = x.__array_namespace__()
    if activation in POLYNOMIALS:
        bound, coefficients = POLYNOMIALS[activation]
        t = x.clip(-bound, bound)
        *others, first = coefficients
        # In place where arrays can be changed, and without t^2: memory counts more than a product.
        q = t * first
        for coefficient in reversed(others):
            q *= t
            q += coefficient
            q *= t
        q += 0.5
        q *= x
        return q
    if activation == "relu":
        return xp.maximum(x, 0.0)
    half = 0.5 * x
    return half + half * xp.tanh(half)  # unlike 1 / (1 + exp(-x)) this cannot overflow


def with_slope(x: Any, activation: str) -> tuple[Any, Any]:
    """`activate` and its derivative."""
    xp = x.__array_namespace__()
    if activation in POLYNOMIALS:
        bound, coefficients = POLYNOMIALS[activation]
        t = x.clip(-bound, bound)
        u = t * t
        logistic = 0.5 + t * _horner(coefficients, u)
        # Beyond the bound t stands still, but there the polynomial's own slope is 0 as well.
        slopes = [(2 * k + 1) * coefficient for k, coefficient in enumerate(coefficients)]
        return x * logistic, logistic + t * _horner(slopes, u)
    if activation == "relu":
        return xp.maximum(x, 0.0), xp.astype(x > 0.0, x.dtype)
    logistic = 0.5 + 0.5 * xp.tanh(0.5 * x)
    return x * logistic, logistic * (1.0 + x * (1.0 - logistic))


def _horner(coefficients: Sequence[float], u: Any) -> Any:
    """The polynomial of u with these coefficients, at least two, lowest power first."""
    *others, second, first = coefficients
    total = second + u * first
    for coefficient in reversed(others):
        total = coefficient + u * total
    return total
