"""The evaluation network and the sampling proxy in Dr.Jit, for the plugins.

The million weights are read from memory, by cooperative vectors in single precision, which Dr.Jit
has on CPUs alone. Mitsuba records a whole path as one kernel, in which every lane reads the weights
for itself. This kernel takes minutes to compile, and ten times as long to run as
`separate_kernels`.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

from fan2022.architecture import EPSILON, EVALUATION, PROXY, Block, Linear, Skip
from fan2022.inference import GaussianMixture
from urushi.core.namespace import DRJIT
from urushi.nets.mlp import Params

#: The flags by which Mitsuba records a whole path as one kernel.
_SYMBOLIC = dr.JitFlag.SymbolicCalls, dr.JitFlag.SymbolicLoops, dr.JitFlag.SymbolicConditionals


@contextlib.contextmanager
def separate_kernels() -> Iterator[None]:
    """Within this context `mi.render` runs a kernel for each layer of these networks.

    The lanes of a layer's kernel read each weight once, together. Activations are in memory and
    take about 4 kB for every ray of a pass.
    """
    with contextlib.ExitStack() as stack:
        for flag in _SYMBOLIC:
            stack.enter_context(dr.scoped_set_flag(flag, False))
        yield


def _stored(x: nn.CoopVec) -> nn.CoopVec:
    """The same activations, in memory within `separate_kernels`."""
    if dr.flag(dr.JitFlag.SymbolicScope) or any(map(dr.flag, _SYMBOLIC)):
        return x
    values = list(x)
    dr.eval(values)
    return nn.CoopVec(*values)


def _packed(weight: np.ndarray, bias: np.ndarray) -> tuple:
    """A weight (out, in) and a bias (out,) in memory, as `nn.matvec` takes them."""
    weight, bias = (np.ascontiguousarray(array, np.float32) for array in (weight, bias))
    return nn.pack(mi.TensorXf(weight), mi.TensorXf(bias), layout="inference")


def bound(params: Params, chain: Sequence[Block]) -> Callable[[nn.CoopVec], nn.CoopVec]:
    """The function of activations that is equal to a chain."""
    steps = [_step(params, block) for block in chain]

    def chained(x: nn.CoopVec) -> nn.CoopVec:
        for step in steps:
            x = _stored(step(x))
        return x

    return chained


def _step(params: Params, block: Block) -> Callable[[nn.CoopVec], nn.CoopVec]:
    """The function that is equal to a block."""
    if isinstance(block, Skip):
        inner = bound(params, block.inner)
        return lambda x: inner(x) + x
    if isinstance(block, Linear):
        weight, bias = _packed(params[f"{block.name}.weight"].T, params[f"{block.name}.bias"])
        return lambda x: nn.matvec(weight, x, bias)
    # A vector in memory can be used only as the bias of a matrix, here of zeros.
    zeros, names = np.zeros((block.width, 1)), (f"{block.name}.scale", f"{block.name}.shift")
    vectors = [_packed(zeros, params[name]) for name in names]
    mean = _packed(np.full((1, block.width), 1 / block.width), np.zeros(1))

    def average(x: nn.CoopVec):
        (value,) = nn.matvec(mean[0], x, mean[1])
        return value

    def normalised(x: nn.CoopVec) -> nn.CoopVec:
        centred = x - average(x)
        inverse = dr.rsqrt(average(centred * centred) + EPSILON)
        scale, shift = (nn.matvec(zero, nn.CoopVec(mi.Float(0)), own) for zero, own in vectors)
        return dr.maximum(dr.fma(centred * inverse, scale, shift), 0)

    return normalised


class PaperDecoder:
    """f [1/sr] from latent codes, by the evaluation network."""

    def __init__(self, params: Params):
        self._network = bound(params, EVALUATION)

    def f(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, never negative; latents: per channel a list (32) of Dr.Jit floats.

        A loop over the channels, whose body holds the network once.
        """
        directions = [wi.x, wi.y, wo.x, wo.y, wi.z, wo.z]

        def evaluate(channel, *values):
            z = [_chosen(channel, numbers) for numbers in zip(*latents, strict=True)]
            (value,) = self._network(nn.CoopVec(*directions, *z))
            value = dr.maximum(value, 0)
            kept = [dr.select(channel == k, value, other) for k, other in enumerate(values)]
            return channel + 1, *kept

        start = (dr.zeros(mi.UInt32), *(dr.zeros(mi.Float) for _ in latents))
        _, *values = dr.while_loop(start, lambda channel, *_: channel < len(latents), evaluate)
        return values


def _chosen(index, values: Sequence):
    """The value at an index that a kernel computes."""
    result = values[0]
    for k, value in enumerate(values[1:], 1):
        result = dr.select(index == k, value, result)
    return result


class PaperSampler:
    """Proposals from latent codes, the same for all directions."""

    def __init__(self, params: Params):
        self._layers = [_step(params, block) for block in PROXY]

    def proposal(self, latent: Sequence) -> GaussianMixture:
        """The proposal of a latent code, a list (32) of Dr.Jit floats."""
        x = self._layers[0](nn.CoopVec(*latent))
        for layer in self._layers[1:]:
            x = layer(dr.maximum(x, 0))
        return GaussianMixture.of_outputs(x, DRJIT)
