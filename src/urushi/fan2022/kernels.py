"""The evaluation network and the sampling proxy in Dr.Jit, for the plugins.

The million weights are read from memory, by cooperative vectors in single precision, which Dr.Jit
has on CPUs alone. Mitsuba records a whole path as one kernel, in which every lane reads the weights
for itself. This kernel takes minutes to compile, and ten times as long to run as
`separate_kernels`.
"""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from drjit import nn

from urushi.core.namespace import DRJIT
from urushi.fan2022.architecture import EPSILON, EVALUATION, PROXY, Block, Linear, Norm
from urushi.fan2022.inference import MIN_SHARE, MIN_SIGMA, GaussianMixture
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
    return nn.pack(mi.TensorXf(weight), mi.TensorXf(bias), layout="inference")


def _linear(params: Mapping[str, np.ndarray], name: str) -> Callable:
    """A linear layer, equal to `fan2022.architecture.Linear`."""
    weight = np.ascontiguousarray(params[f"{name}.weight"].T)
    weight, bias = _packed(weight, params[f"{name}.bias"])
    return lambda x: nn.matvec(weight, x, bias)


def _norm(params: Mapping[str, np.ndarray], name: str) -> Callable:
    """Layer normalisation and ReLU, equal to `fan2022.architecture.Norm`."""
    width = len(params[f"{name}.scale"])
    # A vector in memory can be used only as the bias of a matrix, here of zeros.
    zeros = np.zeros((width, 1), np.float32)
    vectors = [_packed(zeros, params[f"{name}.{part}"]) for part in ("scale", "shift")]
    mean = _packed(np.full((1, width), 1 / width, np.float32), np.zeros(1, np.float32))

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
        self._steps = _bound(params, EVALUATION)

    def f(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, never negative; latents: per channel a list (32) of Dr.Jit floats.

        A loop over the channels, whose body holds the network once.
        """
        directions = [wi.x, wi.y, wo.x, wo.y, wi.z, wo.z]

        def evaluate(channel, *values):
            of_channels = zip(*latents, strict=True)
            z = [_chosen(channel, numbers) for numbers in of_channels]
            (value,) = _chained(self._steps, nn.CoopVec(*directions, *z))
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


def _bound(params: Mapping[str, np.ndarray], chain: Sequence[Block]) -> list:
    """One function of activations for each block of a chain."""
    steps: list = []
    for block in chain:
        if isinstance(block, Linear):
            steps.append(_linear(params, block.name))
        elif isinstance(block, Norm):
            steps.append(_norm(params, block.name))
        else:
            steps.append(_skip(_bound(params, block.inner)))
    return steps


def _skip(inner: list) -> Callable:
    return lambda x: _chained(inner, x) + x


def _chained(steps: Sequence[Callable], x: nn.CoopVec) -> nn.CoopVec:
    for step in steps:
        x = _stored(step(x))
    return x


class Gaussian(GaussianMixture):
    """`GaussianMixture` of Dr.Jit floats."""

    def pdf(self, wi, wo):
        return self.density(wi, wo, DRJIT)

    def sample(self, wi, choice, u):  # type: ignore[override]  # as plugins draw
        """Draw wo above the horizon from uniform numbers: `choice`, and two in `u`."""
        return mi.Vector3f(*self.drawn(wi, choice, u.x, u.y, DRJIT))


class PaperSampler:
    """Proposals from latent codes, the same for all directions."""

    def __init__(self, params: Params):
        self._steps = _bound(params, PROXY)

    def proposal(self, latent: Sequence) -> Gaussian:
        """The proposal of a latent code, a list (32) of Dr.Jit floats."""
        x = self._steps[0](nn.CoopVec(*latent))
        for step in self._steps[1:]:
            x = step(dr.maximum(x, 0))
        size, share = (1 / (1 + dr.exp(value)) for value in x)
        return Gaussian(
            dr.exp(float(np.log(MIN_SIGMA)) * size), MIN_SHARE + (1 - 2 * MIN_SHARE) * share
        )
