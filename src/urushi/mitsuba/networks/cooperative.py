"""Networks as Dr.Jit code with weights in memory, by cooperative vectors.

GPUs evaluate these on their matrix units in half precision. CPUs use them for networks that have
too many weights for the unrolled code of `mlp`. Activations stay cooperative vectors throughout:
separate floats would make the code long and its compilation slow.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

from urushi.mitsuba.networks import mlp
from urushi.nets.mlp import POLYNOMIALS


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
    """The layers of a network after its first one; see `mlp.hidden_to_output`.

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
        return mlp.dense([mi.Float(value) for value in x], self._weight, self._bias)

    def _activate(self, x: nn.CoopVec) -> nn.CoopVec:
        if self._activation == "relu":
            return dr.maximum(x, 0)
        if self._activation in POLYNOMIALS:
            bound, coefficients = POLYNOMIALS[self._activation]
            t = dr.minimum(dr.maximum(x, -bound), bound)
            return x * dr.fma(t, mlp.horner(coefficients, t * t), 0.5)
        half = x * 0.5
        return dr.fma(half, dr.tanh(half), half)  # SiLU, as in `nets.mlp.activate`


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
    return partial(mlp.hidden_to_output, params, prefix, activation=activation)
