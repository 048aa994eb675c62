"""Perceptrons of single BRDFs and their training, which the networks of all authors share.

RGB is exp(x) - 1 of the last layer. The loss is the mean of |ln(1 + f' cos) - ln(1 + f cos)|
(Sztrajman et al. 2021). Half angles are drawn as squares, like MERL's bins, which resolves
highlights, and the rate of Adam decays as half a cosine.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
from benchmarks.measures import Brdf

from urushi.core.directions import directions_at

#: Weights (inputs, outputs) and bias (outputs,) of each layer.
Layers = tuple[tuple[Any, Any], ...]
#: Samples per step of a training by passes.
BATCH = 512


def perceptron(layers: Layers, x: Any, xp: ModuleType) -> Any:
    """Layers with ReLU between them, with NumPy or JAX."""
    for i, (weights, bias) in enumerate(layers):
        x = x @ weights + bias
        x = x if i == len(layers) - 1 else xp.maximum(x, 0)
    return x


def size(layers: Layers) -> int:
    """Number of weights and biases."""
    return sum(weights.size + bias.size for weights, bias in layers)


def initial(rng: np.random.Generator, sizes: tuple[int, ...]) -> Layers:
    """Initial layers of these widths, inputs first (Glorot and Bengio 2010); biases are zero."""
    return tuple(
        (
            np.float32(rng.uniform(-1, 1, shape) * np.sqrt(6 / sum(shape))),
            np.zeros(shape[1], np.float32),
        )
        for shape in itertools.pairwise(sizes)
    )


def training_data(f: Brdf, samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs wi, wo and values of a BRDF, float32 (N, 3)."""
    wi, wo = training_pairs(np.random.default_rng(0), samples)
    return wi, wo, np.broadcast_to(np.asarray(f(wi, wo), np.float32), (len(wi), 3))


def training_pairs(rng: np.random.Generator, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Float32 unit vectors (N, 3) of the drawn pairs above the horizon, about three quarters."""
    u = rng.random((3, samples))
    angles = u[0] ** 2 * (np.pi / 2), u[1] * (np.pi / 2), u[2] * np.pi
    wi, wo = (w.astype(np.float32) for w in directions_at(*angles))
    above = np.minimum(wi[:, 2], wo[:, 2]) > 0
    return wi[above], wo[above]


def log_error(logits: Any, values: Any, cosine: Any) -> Any:
    """The loss of ln(1 + f') (..., 3) against values (..., 3) at cosines (..., 1)."""
    return jnp.mean(jnp.abs(jnp.log1p(jnp.expm1(logits) * cosine) - jnp.log1p(values * cosine)))


def by_passes(
    loss: Callable[..., Any], parameters: Any, data: Any, rate: float, passes: int
) -> Any:
    """`minimised` by passes over all rows of data, in a new order each.

    loss: (parameters, rows of data, key) -> number.
    """
    steps, key = len(data[0]) // BATCH, jax.random.key(0)

    def drawn() -> Iterator[Any]:
        for i in range(passes):
            keys = jax.random.split(jax.random.fold_in(key, i), steps + 1)
            order = jax.random.permutation(keys[0], len(data[0]))[: steps * BATCH]
            yield order.reshape(steps, BATCH), keys[1:]

    return minimised(partial(_of_rows, loss), parameters, data, drawn(), rate, passes * steps)


def _of_rows(loss: Callable[..., Any], parameters: Any, data: Any, drawn: Any) -> Any:
    rows, key = drawn
    return loss(parameters, tuple(array[rows] for array in data), key)


def minimised(
    loss: Callable[..., Any], parameters: Any, data: Any, draws: Iterable[Any], rate: float, n: int
) -> Any:
    """Parameters of the least loss(parameters, data, drawn), by n steps of Adam.

    draws: parts of the training, each the arrays of what its steps draw.
    """
    rule = optax.adam(optax.cosine_decay_schedule(rate, n))
    parameters, data = (jax.tree.map(jnp.asarray, tree) for tree in (parameters, data))
    state = parameters, rule.init(parameters)
    for drawn in draws:
        state = _steps(rule, loss, state, data, drawn)
    return jax.tree.map(np.asarray, state[0])


@partial(jax.jit, static_argnums=(0, 1))
def _steps(rule: Any, loss: Any, state: Any, data: Any, drawn: Any) -> Any:
    def step(state: Any, own: Any) -> tuple[Any, None]:
        parameters, moments = state
        update, moments = rule.update(jax.grad(loss)(parameters, data, own), moments)
        return (optax.apply_updates(parameters, update), moments), None

    return jax.lax.scan(step, state, drawn)[0]
