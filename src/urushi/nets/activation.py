"""The activations of hidden layers, and their derivatives."""

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
        t, q, _ = _polynomial(x, activation)
        return x * (0.5 + t * q)
    if activation == "relu":
        return xp.maximum(x, 0.0)
    half = 0.5 * x
    return half + half * xp.tanh(half)  # unlike 1 / (1 + exp(-x)) this cannot overflow


def slope(x: Any, activation: str) -> Any:
    """The derivative of `activate`."""
    xp = x.__array_namespace__()
    if activation in POLYNOMIALS:
        t, q, growth = _polynomial(x, activation)
        return 0.5 + t * (2.0 * q + growth)
    if activation == "relu":
        return xp.astype(x > 0.0, x.dtype)
    logistic = 0.5 + 0.5 * xp.tanh(0.5 * x)
    return logistic * (1.0 + x * (1.0 - logistic))


def _polynomial(x: Any, activation: str) -> tuple[Any, Any, Any]:
    """t, q(t^2) and t times its derivative by t."""
    bound, coefficients = POLYNOMIALS[activation]
    t = x.__array_namespace__().clip(x, -bound, bound)
    u = t * t
    q, growth = coefficients[-1], 2 * (len(coefficients) - 1) * coefficients[-1]
    for power in reversed(range(len(coefficients) - 1)):
        q = coefficients[power] + u * q
        growth = 2 * power * coefficients[power] + u * growth
    return t, q, growth
