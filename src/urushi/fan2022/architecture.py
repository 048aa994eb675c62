"""The paper's networks as chains of blocks, of fixed sizes (Fan et al. 2022, figures 2 and 3).

A network is a chain of blocks, kept as a tuple. `apply` runs on NumPy and JAX. `pulled_back` also
returns the gradient with respect to the input, written by hand, so that latent codes can be
optimised where JAX is not installed.
"""

import itertools
import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.nets.mlp import Params, linear, product

#: Added to the variance in layer normalisation; PyTorch's default.
EPSILON = 1e-5

Pullback = Callable[[Any], Any]
Shapes = dict[str, tuple[int, ...]]


@dataclass(frozen=True)
class Linear:
    """x (..., rows) times a weight, plus a bias: (..., columns)."""

    name: str
    rows: int
    columns: int

    def shapes(self) -> Shapes:
        """The parameters' shapes by name."""
        return {
            f"{self.name}.weight": (self.rows, self.columns),
            f"{self.name}.bias": (self.columns,),
        }

    def apply(self, params: Params, x: Any) -> Any:
        return linear(params, self.name, x)

    def pulled_back(self, params: Params, x: Any) -> tuple[Any, Pullback]:
        """Evaluate, and a function from the output's gradient to the input's."""
        weight = params[f"{self.name}.weight"]
        return self.apply(params, x), lambda dy: product(dy, weight.T)


def _row_means(x: Any) -> Any:
    """Means (..., 1) over the last axis, as a product: XLA adds up rows slowly on a CPU."""
    xp = x.__array_namespace__()
    return product(x, xp.full((x.shape[-1], 1), 1 / x.shape[-1], dtype=x.dtype))


@dataclass(frozen=True)
class Norm:
    """Layer normalisation (Ba et al. 2016) over the last axis, then ReLU."""

    name: str
    width: int

    def shapes(self) -> Shapes:
        return {f"{self.name}.scale": (self.width,), f"{self.name}.shift": (self.width,)}

    def apply(self, params: Params, x: Any) -> Any:
        return self._evaluate(params, x)[0]

    def pulled_back(self, params: Params, x: Any) -> tuple[Any, Pullback]:
        xp = x.__array_namespace__()
        y, normal, inverse = self._evaluate(params, x)
        scale = params[f"{self.name}.scale"]

        def pull(dy: Any) -> Any:
            d = xp.where(y > 0, dy, 0) * scale
            return (d - _row_means(d) - normal * _row_means(d * normal)) * inverse

        return y, pull

    def _evaluate(self, params: Params, x: Any) -> tuple[Any, Any, Any]:
        xp = x.__array_namespace__()
        centred = x - _row_means(x)
        inverse = 1 / xp.sqrt(_row_means(centred * centred) + EPSILON)
        normal = centred * inverse
        y = normal * params[f"{self.name}.scale"] + params[f"{self.name}.shift"]
        return xp.maximum(y, 0), normal, inverse


@dataclass(frozen=True)
class Skip:
    """R{m} = m(x) + x for a chain of blocks m."""

    inner: tuple["Block", ...]

    def shapes(self) -> Shapes:
        return shapes(self.inner)

    def apply(self, params: Params, x: Any) -> Any:
        return apply(params, self.inner, x) + x

    def pulled_back(self, params: Params, x: Any) -> tuple[Any, Pullback]:
        y, pull = pulled_back(params, self.inner, x)
        return y + x, lambda dy: pull(dy) + dy


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
    for block in blocks:
        x = block.apply(params, x)
    return x


def pulled_back(params: Params, blocks: Iterable[Block], x: Any) -> tuple[Any, Pullback]:
    """Evaluate a chain, and a function from its output's gradient to its input's."""
    pulls: list[Pullback] = []
    for block in blocks:
        x, pull = block.pulled_back(params, x)
        pulls.append(pull)

    def through(dy: Any) -> Any:
        for pull in reversed(pulls):
            dy = pull(dy)
        return dy

    return x, through


def drawn(blocks: Iterable[Block], rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Draw float32 parameters as PyTorch does; the paper does not state the initialisation.

    Weights and biases are uniform within +-1 / sqrt(rows); scales are 1 and shifts 0.
    """
    params: dict[str, np.ndarray] = {}
    bound = 1.0
    for name, shape in shapes(blocks).items():
        kind = name.rsplit(".", 1)[1]
        if kind == "weight":
            bound = shape[0] ** -0.5
        if kind in ("weight", "bias"):
            params[name] = rng.uniform(-bound, bound, shape).astype(np.float32)
        else:
            params[name] = np.full(shape, 1.0 if kind == "scale" else 0.0, np.float32)
    return params


LATENT = 32

#: Initial value of every entry of a latent code.
FIRST_LATENT = 1.0

#: Number of direction inputs of the evaluation network, which precede the latent code.
DIRECTIONS = 6


@dataclass(frozen=True)
class AdamProjection:
    """Options of the projection by Adam (`urushi.fan2022.projection`); the authors' by default."""

    steps: int = 1000  # up to a million
    pairs: int = 4096  # direction pairs of a step, up to 2^20

    def __post_init__(self) -> None:
        for name, most in (("steps", 1_000_000), ("pairs", 1 << 20)):
            value = getattr(self, name)
            if type(value) is not int or not 1 <= value <= most:
                raise ParameterError(
                    f"the projection by Adam has {name} = {value!r}; give a whole number from 1 to "
                    f"{most}"
                )


@dataclass(frozen=True)
class PaperArchitecture:
    """The architecture of the paper's networks; their sizes are fixed."""

    # How a BRDF is projected to a code. A layering network expects codes of the projection that it
    # was trained with.
    adam: AdamProjection

    def to_json(self) -> str:
        """Return kind and projection as the text of a JSON object."""
        return json.dumps({"kind": "paper", **asdict(self)})

    @classmethod
    def from_json(cls, text: str) -> "PaperArchitecture":
        """Read the text that `to_json` returns; a ParameterError if it has other entries."""
        match json.loads(text):
            case {"kind": "paper", "adam": {"steps": steps, "pairs": pairs, **no}, **more} if not (
                no or more
            ):
                return cls(AdamProjection(steps, pairs))
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

PARTS = {"evaluation": EVALUATION, "layering": LAYERING, "proxy": PROXY}


def parameter_shapes() -> Shapes:
    """Return every parameter's shape by name."""
    return {name: shape for part in PARTS.values() for name, shape in shapes(part).items()}


def init(seed: int) -> dict[str, np.ndarray]:
    """Draw initial parameters of all three networks."""
    rng = np.random.default_rng(seed)
    return {name: v for part in PARTS.values() for name, v in drawn(part, rng).items()}
