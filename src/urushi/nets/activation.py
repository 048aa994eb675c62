"""The activations of hidden layers, and their derivatives."""

from collections.abc import Sequence
from typing import Any

#: Activations x (1/2 + t q(t^2)), t being x held within plus and minus the first number; the others
#: are q's coefficients, lowest power first. There q has brought the bracket to 1, or 0, and its
#: slope to 0. "smoothstep" is the plainest; "silu7" is within 0.02 of SiLU.
POLYNOMIALS = {
    "smoothstep": (2.0, (0.375, -0.03125)),
    "silu7": (5.75, (0.225729, -0.010473, 2.924521977775268e-4, -3.1043713096403e-6)),
}


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
