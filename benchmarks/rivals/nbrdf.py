"""Neural BRDFs of 675 weights, one network for each material (Sztrajman et al. 2021).

Half and difference vectors (Rusinkiewicz 1998), as six numbers, pass two hidden layers of 21 ReLU.
RGB is exp(x) - 1 of the last layer. The loss is the mean of |ln(1 + f' cos) - ln(1 + f cos)|. Half
angles are drawn as squares, like MERL's bins, which resolves highlights, and the rate of Adam
decays as half a cosine. The networks of all other authors share this training.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
import optax
from benchmarks.measures import Brdf

from urushi.core.directions import directions_at, half_difference
from urushi.core.namespace import NUMPY, components
from urushi.measured.tabulated import evaluate

#: Weights (inputs, outputs) and bias (outputs,) of each layer.
Layers = tuple[tuple[Any, Any], ...]
#: Samples per step of a training by passes.
BATCH = 512
#: Widths of the layers, the inputs first; number of weights of a material.
SIZES = (6, 21, 21, 3)
SIZE = sum((a + 1) * b for a, b in itertools.pairwise(SIZES))
#: Initial rate of Adam; 30 passes are as good as the authors' 100 at a constant rate of 0.0005.
RATE = 5e-3


class Nbrdf(NamedTuple):
    """A BRDF represented by its own network."""

    layers: Layers

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """float32 (N, 3) [1/sr], without cosine, of unit vectors (N, 3)."""
        return evaluate(lambda *pair: self.at(inputs(*pair)), 3, wi, wo)

    def at(self, x: np.ndarray) -> np.ndarray:
        """f (N, 3) of `vectors`."""
        return np.maximum(np.expm1(perceptron(self.layers, x, np)), 0)


def unpacked(weights: np.ndarray) -> Nbrdf:
    """The network of the 675 weights of a published fit: weights and bias, layer by layer."""
    layers, start = [], 0
    for a, b in itertools.pairwise(SIZES):
        rows = weights[start : start + (a + 1) * b].reshape(a + 1, b)
        layers.append((rows[:-1], rows[-1]))
        start += rows.size
    return Nbrdf(tuple(layers))


def inputs(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """`vectors` of unit vectors (N, 3) above the horizon.

    The azimuth of h is 0; that of d is taken modulo pi, so that f is reciprocal.
    """
    wi, wo = (components(w.astype(np.float64)) for w in (wi, wo))
    return vectors(*half_difference(wi, wo, NUMPY))


def vectors(theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray) -> np.ndarray:
    """h and d, (N, 6), of Rusinkiewicz's angles (N,) [rad]."""
    sin_d = np.sin(theta_d)
    parts = [np.sin(theta_h), np.zeros_like(theta_h), np.cos(theta_h)]
    parts += [sin_d * np.cos(phi_d), sin_d * np.sin(phi_d), np.cos(theta_d)]
    return np.stack(parts, axis=1)


def train(f: Brdf, *, passes: int, samples: int = 640_000) -> Nbrdf:
    """Train the network of a BRDF: 15 seconds of one core; samples: as in the authors' code."""
    wi, wo, values = training_data(f, samples)
    data = np.float32(inputs(wi, wo)), wi[:, 2:], values
    layers = initial(np.random.default_rng((0, 1)), SIZES)

    def loss(layers: Layers, rows: Any, _: Any) -> Any:
        x, cosine, values = rows
        return log_error(perceptron(layers, x, jnp), values, cosine)

    return Nbrdf(by_passes(loss, layers, data, RATE, passes))


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

    def of_rows(parameters: Any, data: Any, drawn: Any) -> Any:
        rows, key = drawn
        return loss(parameters, tuple(array[rows] for array in data), key)

    return minimised(of_rows, parameters, data, drawn(), rate, passes * steps)


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
