"""The paper's networks as chains of blocks, of fixed sizes (Fan et al. 2022, figures 2 and 3).

A network is a chain of blocks, kept as a tuple; `apply` runs on NumPy and JAX.
"""

import itertools
import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.nets.mlp import Params, linear, product

#: Added to the variance in layer normalisation; PyTorch's default.
EPSILON = 1e-5

Shapes = dict[str, tuple[int, ...]]


@dataclass(frozen=True)
class Linear:
    """x (..., rows) times a weight, plus a bias: (..., columns)."""

    name: str
    rows: int
    columns: int

    def shapes(self) -> Shapes:
        """The parameters' shapes by name."""
        weight = {f"{self.name}.weight": (self.rows, self.columns)}
        return {**weight, f"{self.name}.bias": (self.columns,)}

    def apply(self, params: Params, x: Any) -> Any:
        return linear(params, self.name, x)


@dataclass(frozen=True)
class Norm:
    """Layer normalisation (Ba et al. 2016) over the last axis, then ReLU."""

    name: str
    width: int

    def shapes(self) -> Shapes:
        return {f"{self.name}.scale": (self.width,), f"{self.name}.shift": (self.width,)}

    def apply(self, params: Params, x: Any) -> Any:
        xp = x.__array_namespace__()
        # Means are products: XLA adds up rows slowly on a CPU.
        mean = xp.full((self.width, 1), 1 / self.width, dtype=x.dtype)
        centred = x - product(x, mean)
        normal = centred / xp.sqrt(product(centred * centred, mean) + EPSILON)
        return xp.maximum(normal * params[f"{self.name}.scale"] + params[f"{self.name}.shift"], 0)


@dataclass(frozen=True)
class Skip:
    """R{m} = m(x) + x for a chain of blocks m."""

    inner: tuple["Block", ...]

    def shapes(self) -> Shapes:
        return shapes(self.inner)

    def apply(self, params: Params, x: Any) -> Any:
        return apply(params, self.inner, x) + x


Block = Linear | Norm | Skip


def fc(name: str, rows: int, columns: int) -> tuple[Block, ...]:
    """FC(rows, columns): Linear, LayerNorm, ReLU."""
    return Linear(name, rows, columns), Norm(name, columns)


def rb(name: str, n: int) -> tuple[Block, ...]:
    """RB(n): x + Linear(n/2, n)(FC(n, n/2)(x)), then LayerNorm and ReLU."""
    inner = (*fc(f"{name}.in", n, n // 2), Linear(f"{name}.out", n // 2, n))
    return Skip(inner), Norm(name, n)


def shapes(blocks: Iterable[Block]) -> Shapes:
    """The shapes of all parameters of a chain, by name."""
    return {name: shape for block in blocks for name, shape in block.shapes().items()}


def apply(params: Params, blocks: Iterable[Block], x: Any) -> Any:
    """Evaluate a chain on x (..., rows)."""
    for block in blocks:
        x = block.apply(params, x)
    return x


LATENT = 32

#: Initial value of every entry of a latent code.
FIRST_LATENT = 1.0

#: Number of direction inputs of the evaluation network, which precede the latent code.
DIRECTIONS = 6


@dataclass(frozen=True)
class PaperArchitecture:
    """The architecture: sizes are fixed, and only the projection of a BRDF to a code has options.

    A layering network expects codes of the projection that it was trained with.
    """

    steps: int = 1000  # of Adam, up to a million
    pairs: int = 4096  # direction pairs of a step, up to 2^20

    def __post_init__(self) -> None:
        for name, most in (("steps", 1_000_000), ("pairs", 1 << 20)):
            value = getattr(self, name)
            if type(value) is not int or not 1 <= value <= most:
                raise ParameterError(
                    f"the paper's projection has {name} = {value!r}; give a whole number from 1 to "
                    f"{most}"
                )

    def to_json(self) -> str:
        """Return kind and projection as the text of a JSON object."""
        return json.dumps({"kind": "paper", "adam": vars(self)})

    @classmethod
    def from_json(cls, text: str) -> "PaperArchitecture":
        """Read the text that `to_json` returns; a ParameterError if it has other entries."""
        match json.loads(text):
            case {"kind": "paper", "adam": {"steps": steps, "pairs": pairs, **no}, **more} if not (
                no or more
            ):
                return cls(steps, pairs)
        raise ParameterError(
            "the paper's architecture takes no options but the projection; it must be "
            '{"kind": "paper", "adam": {"steps": ..., "pairs": ...}}'
        )


def _nested(name: str, n: int, depth: int) -> tuple[Block, ...]:
    """R{A, FC, A}, where A is of the depth below; RB at depth 0."""
    if depth == 0:
        return rb(name, n)
    first, last = (_nested(f"{name}.{place}", n, depth - 1) for place in (0, 2))
    return (Skip((*first, *fc(f"{name}.1", n, n), *last)),)


#: The evaluation network: 1,074,689 parameters.
EVALUATION = (
    *fc("evaluation.0", DIRECTIONS + LATENT, 256),
    *_nested("evaluation.1", 256, 3),
    *fc("evaluation.2", 256, 256),
    Linear("evaluation.3", 256, 1),
)

_MIDDLE = (
    *rb("layering.1.0", 512),
    *fc("layering.1.1", 512, 512),
    *_nested("layering.1.2", 512, 1),
    *fc("layering.1.3", 512, 512),
    *rb("layering.1.4", 512),
)

#: The layering network: 1,954,208 parameters.
LAYERING = (
    *fc("layering.0", 2 * LATENT + 2, 512),
    Skip(_MIDDLE),
    *fc("layering.2", 512, 128),
    Linear("layering.3", 128, LATENT),
)

#: The sampling proxy, an MLP with plain ReLUs between its layers (evaluated by `nets.mlp`).
PROXY = tuple(
    Linear(f"proxy.{i}", *sizes)
    for i, sizes in enumerate(itertools.pairwise((LATENT, 128, 512, 128, 32, 2)))
)

ALL = *EVALUATION, *LAYERING, *PROXY


def parameters_of(params: Params, network: str) -> dict[str, Any]:
    """The parameters of one network: "evaluation", "layering" or "proxy"."""
    return {name: value for name, value in params.items() if name.startswith(f"{network}.")}


def init(seed: int) -> dict[str, np.ndarray]:
    """Draw float32 parameters of all networks as PyTorch does; the paper does not say how.

    Weights and biases are uniform within +-1 / sqrt(rows); scales are 1 and shifts 0.
    """
    rng, bound, params = np.random.default_rng(seed), 1.0, {}
    for name, shape in shapes(ALL).items():
        kind = name.rsplit(".", 1)[1]
        if kind == "weight":
            bound = shape[0] ** -0.5
        if kind in ("weight", "bias"):
            params[name] = rng.uniform(-bound, bound, shape).astype(np.float32)
        else:
            params[name] = np.full(shape, 1.0 if kind == "scale" else 0.0, np.float32)
    return params
