"""Large networks as Dr.Jit code: weights in memory, as cooperative vectors want them.

For networks whose weights are too many to be constants in unrolled code, as `render.network` has
them. Activations are cooperative vectors throughout: taken apart into floats they would make the
code long and its compilation slow.
"""

from collections.abc import Mapping

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

from urushi.nets.paper.blocks import EPSILON


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


def _packed(weight: np.ndarray, bias: np.ndarray) -> tuple:
    return nn.pack(mi.TensorXf(weight), mi.TensorXf(bias), layout="inference")
