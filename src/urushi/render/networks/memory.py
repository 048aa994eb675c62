"""Networks as Dr.Jit code with weights in memory, as cooperative vectors want them.

For GPUs, whose matrix units take them, in half precision; and, on CPUs, for networks whose weights
are too many to be constants in unrolled code, as `network` has them. Activations are cooperative
vectors throughout: taken apart into floats they would make the code long and its compilation slow.
"""

from collections.abc import Mapping, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

from urushi.nets.activation import POLYNOMIALS
from urushi.nets.paper.blocks import EPSILON
from urushi.render.networks import network


class Linear:
    """A linear layer called `name`."""

    def __init__(self, params: Mapping[str, np.ndarray], name: str):
        weight = np.ascontiguousarray(params[f"{name}.weight"].T)
        self._layer = _packed(weight, params[f"{name}.bias"])

    def __call__(self, x: nn.CoopVec) -> nn.CoopVec:
        """Apply to activations."""
        weight, bias = self._layer
        return nn.matvec(weight, x, bias)


class Norm:
    """Layer normalisation and ReLU, as `nets.paper.blocks.Norm`."""

    def __init__(self, params: Mapping[str, np.ndarray], name: str):
        scale, shift = params[f"{name}.scale"], params[f"{name}.shift"]
        width = len(scale)
        none = np.zeros((width, 1), np.float32)
        # A vector in memory becomes an operand as the offset of a matrix of zeros.
        self._scale, self._shift = _packed(none, scale), _packed(none, shift)
        self._mean = _packed(np.full((1, width), 1 / width, np.float32), np.zeros(1, np.float32))

    def __call__(self, x: nn.CoopVec) -> nn.CoopVec:
        """Apply to activations."""
        centred = x - self._average(x)
        inverse = dr.rsqrt(self._average(centred * centred) + EPSILON)
        scale, shift = (
            nn.matvec(weight, nn.CoopVec(mi.Float(0)), bias)
            for weight, bias in (self._scale, self._shift)
        )
        return dr.maximum(dr.fma(centred * inverse, scale, shift), 0)

    def _average(self, x: nn.CoopVec):
        weight, bias = self._mean
        (average,) = nn.matvec(weight, x, bias)
        return average


class Hidden:
    """The hidden layers of a network after its first, the twin of `network.hidden_to_output`.

    The output layer is left to constants in single precision: outputs are logarithms, of which
    half precision would leave three digits.
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
        x = self._activate(nn.CoopVec(*map(_number(), first)))
        for layer in self._layers:
            x = self._activate(layer(x))
        return network.dense([mi.Float(value) for value in x], self._weight, self._bias)

    def _activate(self, x: nn.CoopVec) -> nn.CoopVec:
        if self._activation == "relu":
            return dr.maximum(x, 0)
        if self._activation in POLYNOMIALS:
            bound, coefficients = POLYNOMIALS[self._activation]
            t = dr.minimum(dr.maximum(x, -bound), bound)
            return x * dr.fma(t, network.horner(coefficients, t * t), 0.5)
        half = x * 0.5
        return dr.fma(half, dr.tanh(half), half)  # SiLU, as `nets.activation.activate` has it


def _number() -> type:
    """What cooperative vectors hold: GPUs have half precision only."""
    return mi.Float16 if dr.backend_v(mi.Float) == dr.JitBackend.CUDA else mi.Float


def _packed(weight: np.ndarray, bias: np.ndarray) -> tuple:
    tensor = dr.tensor_t(_number())
    return nn.pack(tensor(weight), tensor(bias), layout="inference")
