"""Multilayer perceptrons as Dr.Jit code, in two forms.

By constants: every weight is a constant in unrolled multiply-adds. On LLVM this is about ten times
as fast as matrices in memory, because a constant costs no load of its own. The cost is compile
time, so a network that is used several times is compiled once.

By cooperative vectors: weights are in memory. GPUs evaluate these on their matrix units in half
precision. CPUs use them for networks that have too many weights for unrolled code. Activations stay
cooperative vectors throughout: separate floats would make the code long and its compilation slow.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

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
    return x * dr.fma(t, horner(coefficients, t * t), 0.5)


def horner(coefficients: Sequence[float], u):
    """The polynomial of u with these coefficients, at least two, lowest power first."""
    *others, second, first = coefficients
    total = dr.fma(u, first, second)
    for coefficient in reversed(others):
        total = dr.fma(u, total, coefficient)
    return total


def dense(x: Sequence, weight: np.ndarray, bias: Sequence) -> list:
    """Multiply the list x (in) by a constant weight (in, out) and add bias (out): a list (out).

    `BLOCK` outputs are accumulated at a time, because a processor can hold them in its registers;
    each input is loaded once for all of them. A scope per input enforces this order. Without it,
    Dr.Jit computes one output after the other, at two thirds of the speed or less.
    """
    return _dense([x], weight, bias, BLOCK)[0]


def dense_each(xs: Sequence[Sequence], weight: np.ndarray, bias: Sequence) -> list[list]:
    """`dense` of several lists, the same weight and bias for all of them.

    A weight is loaded once for all lists. Loading weights takes longer than the products, because
    they fill the first-level cache.
    """
    return _dense(xs, weight, bias, max(SHARED_BLOCK // len(xs), 1))


def _dense(xs: Sequence[Sequence], weight: np.ndarray, bias: Sequence, block: int) -> list[list]:
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


class Linear:
    """A linear layer called `name`."""

    def __init__(self, params: Mapping[str, np.ndarray], name: str):
        weight = np.ascontiguousarray(params[f"{name}.weight"].T)
        self._layer = pack(weight, params[f"{name}.bias"])

    def __call__(self, x: nn.CoopVec) -> nn.CoopVec:
        """Apply to activations."""
        weight, bias = self._layer
        return nn.matvec(weight, x, bias)


class Hidden:
    """The layers of a network after its first one; see `hidden_to_output`.

    The output layer has constant weights in single precision: outputs are logarithms, and half
    precision has only three digits.
    """

    def __init__(self, params: Mapping[str, np.ndarray], prefix: str, activation: str):
        last = 1
        while f"{prefix}.{last + 1}.weight" in params:
            last += 1
        self._layers = [Linear(params, f"{prefix}.{index}") for index in range(1, last)]
        self._weight = params[f"{prefix}.{last}.weight"]
        self._bias = params[f"{prefix}.{last}.bias"].tolist()
        self._activation = activation

    def __call__(self, first: Sequence) -> list:
        """Carry the first layer's pre-activation, a list of floats, to the output, another."""
        x = self._activate(_vector(first))
        for layer in self._layers:
            x = self._activate(layer(x))
        return dense([mi.Float(value) for value in x], self._weight, self._bias)

    def _activate(self, x: nn.CoopVec) -> nn.CoopVec:
        if self._activation == "relu":
            return dr.maximum(x, 0)
        bound, coefficients = POLYNOMIALS[self._activation]
        t = dr.minimum(dr.maximum(x, -bound), bound)
        return x * dr.fma(t, horner(coefficients, t * t), 0.5)


def _vector(values: Sequence) -> nn.CoopVec:
    """Floats as one cooperative vector."""
    return nn.CoopVec(*map(_number(), values))


def _number() -> type:
    """The component type of cooperative vectors: GPUs support half precision only."""
    return mi.Float16 if dr.backend_v(mi.Float) == dr.JitBackend.CUDA else mi.Float


def pack(weight: np.ndarray, bias: np.ndarray) -> tuple:
    """A weight (out, in) and a bias (out,) in memory, as `nn.matvec` takes them."""
    tensor = dr.tensor_t(_number())
    return nn.pack(tensor(weight), tensor(bias), layout="inference")


def hidden_layers(
    params: Mapping[str, np.ndarray], prefix: str, activation: str, cooperative: bool | None = None
) -> Callable[[Sequence], list]:
    """The function from a network's first pre-activation to its output, both lists.

    cooperative: whether by cooperative vectors. None: on CUDA, where hardware supports them.
    """
    if cooperative is None:
        cooperative = dr.backend_v(mi.Float) == dr.JitBackend.CUDA
    if cooperative:
        return Hidden(params, prefix, activation)
    return partial(hidden_to_output, params, prefix, activation=activation)
