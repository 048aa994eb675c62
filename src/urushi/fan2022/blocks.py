"""The blocks of the paper's networks: parameter shapes, evaluation and gradient.

A network is a chain of blocks, kept as a tuple. `apply` runs on NumPy and JAX. `pulled_back` also
returns the gradient with respect to the input, written by hand, so that latent codes can be
optimised where JAX is not installed.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

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


def init(blocks: Iterable[Block], rng: np.random.Generator) -> dict[str, np.ndarray]:
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
