"""Multilayer perceptrons as Dr.Jit code.

Every weight is a constant in unrolled multiply-adds. On CPUs this is about ten times as fast as
matrices in memory, because a constant costs no load of its own. On GPUs it is faster than
cooperative vectors, which have half precision only. The cost is compile time.
"""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.mlp import POLYNOMIALS


def activate(x, activation: str):
    """Apply `nets.mlp.activate` to one Dr.Jit float."""
    # Selections, because dr.maximum and dr.clip handle NaN, at six times the cost.
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
    """Multiply the list x (in) by a constant weight (in, out) and add bias (out): a list (out).

    All outputs are accumulated at a time, in a processor's registers, and each input is loaded once
    for all of them. A scope per input enforces this order. Without it, Dr.Jit computes one output
    after the other, at two thirds of the speed or less.

    out: at most 20, since processors have 16 or 32 vector registers.
    """
    totals = [mi.Float(offset) for offset in bias]
    for value, row in zip(x, weight.astype(float).tolist(), strict=True):
        dr.detail.new_scope(dr.backend_v(mi.Float))
        totals = [dr.fma(value, factor, total) for factor, total in zip(row, totals, strict=True)]
    return totals
