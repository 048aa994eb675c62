"""Multilayer perceptrons as Dr.Jit code.

Every weight is a constant in unrolled multiply-adds. On CPUs this is about ten times as fast as
matrices in memory, because a constant costs no load of its own. On GPUs it is faster than
cooperative vectors, which have half precision only. The cost is compile time, so a network that is
used several times is compiled once.
"""

from collections.abc import Mapping, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.mlp import POLYNOMIALS

#: Outputs of a layer that are accumulated at the same time, for one input and for several.
#: Processors have 16 or 32 vector registers, of which some hold inputs and weights.
BLOCK, SHARED_BLOCK = 20, 9


def activate(x, activation: str):
    """Apply `nets.mlp.activate` to one Dr.Jit float."""
    # Selections, because dr.maximum and dr.clip handle NaN, at six times the cost.
    if activation == "relu":
        return dr.select(x > 0, x, 0)
    bound, coefficients = POLYNOMIALS[activation]
    t = dr.select(x > -bound, x, -bound)
    t = dr.select(t < bound, t, bound)  # one instruction each, unlike nested selections
    *others, second, highest = coefficients  # of a polynomial of t^2, lowest power first
    u = t * t
    total = dr.fma(u, highest, second)
    for coefficient in reversed(others):
        total = dr.fma(u, total, coefficient)
    return x * dr.fma(t, total, 0.5)


def dense(x: Sequence, weight: np.ndarray, bias: Sequence) -> list:
    """Multiply the list x (in) by a constant weight (in, out) and add bias (out): a list (out)."""
    return dense_each([x], weight, bias)[0]


def dense_each(xs: Sequence[Sequence], weight: np.ndarray, bias: Sequence) -> list[list]:
    """`dense` of several lists, the same weight and bias for all of them.

    `BLOCK` outputs are accumulated at a time, because a processor can hold them in its registers;
    each input is loaded once for all of them. A scope per input enforces this order. Without it,
    Dr.Jit computes one output after the other, at two thirds of the speed or less.

    A weight is loaded once for all lists. Loading weights takes longer than the products, because
    they fill the first-level cache.
    """
    block = BLOCK if len(xs) == 1 else max(SHARED_BLOCK // len(xs), 1)
    totals = [[mi.Float(offset) for offset in bias] for _ in xs]
    columns = weight.astype(float).T.tolist()
    for first in range(0, len(columns), block):
        outputs = range(first, min(first + block, len(columns)))
        for i, values in enumerate(zip(*xs, strict=True)):
            dr.detail.new_scope(dr.backend_v(mi.Float))
            for k in outputs:
                for total, value in zip(totals, values, strict=True):
                    total[k] = dr.fma(value, columns[k][i], total[k])
    return totals


def hidden_to_output(
    params: Mapping[str, np.ndarray],
    prefix: str,
    first: Sequence,
    activation: str,
) -> list:
    """Carry the first layer's pre-activation, a list, through the rest of the network."""
    index, x = 1, list(first)
    while f"{prefix}.{index}.weight" in params:
        weight, bias = params[f"{prefix}.{index}.weight"], params[f"{prefix}.{index}.bias"].tolist()
        x = dense([activate(value, activation) for value in x], weight, bias)
        index += 1
    return x
