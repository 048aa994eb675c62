"""Multilayer perceptrons as Dr.Jit code: every weight is a constant in unrolled multiply-adds.

On LLVM this is about ten times as fast as matrices in memory, because a constant costs no load of
its own. The price is compile time, so a network that is needed several times is compiled once. On
GPUs `memory` has the faster form; `hidden.choose` decides.

The form of a network's hidden layers that is fastest where it runs.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.mlp import POLYNOMIALS

#: Outputs of a layer that are summed up at the same time: of the 32 registers of AVX-512 some must
#: be left for inputs and weights.
BLOCK = 20


def activate(x, activation: str):
    """Apply `nets.mlp.activate` to one Dr.Jit float."""
    # Selections all through: dr.maximum and dr.clip take care of NaN, at six times the price.
    if activation == "relu":
        return dr.select(x > 0, x, 0)
    if activation in POLYNOMIALS:
        bound, coefficients = POLYNOMIALS[activation]
        t = dr.select(x < bound, dr.select(x > -bound, x, -bound), bound)
        return x * dr.fma(t, horner(coefficients, t * t), 0.5)
    return x / (1 + dr.exp(-x))  # exp may overflow to infinity: the quotient is 0 then, rightly


def horner(coefficients: Sequence[float], u):
    """The polynomial of u with these coefficients, at least two, lowest power first."""
    *others, second, first = coefficients
    total = dr.fma(u, first, second)
    for coefficient in reversed(others):
        total = dr.fma(u, total, coefficient)
    return total


def dense(x: Sequence, weight: np.ndarray, bias: Sequence) -> list:
    """Multiply the list x (in) by a constant weight (in, out) and add bias (out): a list (out).

    Outputs are summed up `BLOCK` at a time, which a processor can hold in its registers, and input
    after input, which is then loaded once for all of them. Code is emitted scope by scope; left to
    itself Dr.Jit would finish one output after the other, at two thirds of the speed and less.
    """
    totals = [mi.Float(offset) for offset in bias]
    columns = weight.astype(float).T.tolist()
    for first in range(0, len(totals), BLOCK):
        block = range(first, min(first + BLOCK, len(totals)))
        for i, value in enumerate(x):
            dr.detail.new_scope(dr.backend_v(mi.Float))
            for k in block:
                totals[k] = dr.fma(value, columns[k][i], totals[k])
    return totals


def hidden_to_output(params: Mapping[str, np.ndarray], prefix: str, first, activation: str) -> list:
    """Carry the first layer's pre-activation, a list, through the rest of the network."""
    index, x = 1, list(first)
    while f"{prefix}.{index}.weight" in params:
        bias = params[f"{prefix}.{index}.bias"].tolist()
        hidden = [activate(value, activation) for value in x]
        x = dense(hidden, params[f"{prefix}.{index}.weight"], bias)
        index += 1
    return x


def compiled_once(function: Callable, *args):
    """Return function(*args), as a call of a routine that kernels hold once, however often called.

    Dr.Jit merges routines with equal code, of different materials too.
    """
    return dr.switch(mi.UInt32(0), [function], *args)


def only_where(active, function: Callable, *args):
    """Return function(*args), zeros where not active.

    Kernels jump over it where none of the lanes that they treat at once is active, as where the
    rays have left the scene.
    """
    shape: list[Any] = []

    def wanted(*args):
        result = function(*args)
        shape.append(result)
        return _flat(result)

    def unwanted(*args):
        return [dr.zeros(type(value)) for value in _flat(shape[0])]

    return _shaped(shape, dr.if_stmt(args, active, wanted, unwanted))


def _flat(nested: Any) -> list:
    """The Dr.Jit floats of nested lists and named tuples."""
    if isinstance(nested, list | tuple):
        return [value for part in nested for value in _flat(part)]
    return [nested]


def _shaped(shape: list, flat: list) -> Any:
    """The inverse of `_flat`; shape: a list of one such nested list."""
    return _filled(shape[0], iter(flat))


def _filled(part: Any, values: Iterator) -> Any:
    # No closure that calls itself: it would keep the values until Python looks for cycles, and what
    # is freed while a frozen function is recorded must not be a scene's last trace.
    filled = [_filled(p, values) if isinstance(p, list | tuple) else next(values) for p in part]
    return type(part)(*filled) if hasattr(part, "_fields") else filled
