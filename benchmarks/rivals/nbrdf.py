"""Neural BRDFs: one network of 675 weights for each material (Sztrajman et al. 2021).

Half and difference vectors (Rusinkiewicz 1998), as six numbers, pass two hidden layers of 21 ReLU;
RGB is exp(x) - 1, clipped at zero. Where the authors leave a choice, training uses what gives the
best pictures of spheres: half angles are drawn as squares, like MERL's bins, which resolves
highlights, and the rate of Adam decays.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
import optax

from urushi.core.directions import directions_at, half_difference_angles
from urushi.errors import ParameterError
from urushi.measured.tabulated import evaluate

#: Shapes of weights and biases, in the order in which they are stored.
SHAPES = (6, 21), (21,), (21, 21), (21,), (21, 3), (3,)

#: Number of weights of a material.
SIZE = sum(int(np.prod(shape)) for shape in SHAPES)


@dataclass(frozen=True, eq=False)
class Nbrdf:
    """A BRDF represented by its own network.

    Attributes:
        weights: (675,) numbers in the order of `SHAPES`.
    """

    weights: np.ndarray

    def __post_init__(self) -> None:
        weights = np.array(self.weights, np.float64)
        if weights.shape != (SIZE,) or not np.isfinite(weights).all():
            raise ParameterError(
                f"a neural BRDF has {SIZE} finite weights; these have shape {weights.shape}"
            )
        weights.flags.writeable = False
        object.__setattr__(self, "weights", weights)

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.maximum(np.expm1(logits(self.weights, inputs(wi, wo))), 0)


def inputs(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The network's inputs h and d, (N, 6) float64, of unit vectors (N, 3) above the horizon.

    The azimuth of h is 0; that of d is taken modulo pi, so that f is reciprocal.
    """
    return vectors(*half_difference_angles(wi.astype(np.float64), wo.astype(np.float64)))


def vectors(theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray) -> np.ndarray:
    """h and d, (N, 6), of Rusinkiewicz's angles (N,) [rad]."""
    sin_d = np.sin(theta_d)
    parts = [np.sin(theta_h), np.zeros_like(theta_h), np.cos(theta_h)]
    parts += [sin_d * np.cos(phi_d), sin_d * np.sin(phi_d), np.cos(theta_d)]
    return np.stack(parts, axis=1)


def logits(weights: Any, x: Any, xp: ModuleType = np) -> Any:
    """ln(1 + f) by channel (N, 3), of weights (675,) and inputs (N, 6), with NumPy or JAX."""
    start = 0
    for i, shape in enumerate(SHAPES):
        size = int(np.prod(shape))
        part = weights[start : start + size].reshape(shape)
        start += size
        if len(shape) == 2:
            x = x @ part
        else:
            x = x + part
            x = x if i == len(SHAPES) - 1 else xp.maximum(x, 0)
    return x


#: Number of samples, and samples per step, as in the authors' code.
SAMPLES, BATCH = 640_000, 512

#: Passes over the samples; the authors' 100 passes at a constant rate of 0.0005 are no better.
PASSES = 30

#: Initial rate of Adam; it decays as half a cosine.
RATE = 5e-3


def train(
    f: Callable[[np.ndarray, np.ndarray], np.ndarray],
    *,
    passes: int = PASSES,
    samples: int = SAMPLES,
) -> Nbrdf:
    """Train the network of a BRDF: 15 seconds of one core.

    The loss is the authors' mean of |ln(1 + f' cos) - ln(1 + f cos)|.

    Args:
        f: f(wi, wo) -> (N, 3) or (N, 1) [1/sr] for float32 unit vectors (N, 3).
        passes: number of passes over all samples.
        samples: number of pairs of directions that are drawn.
    """
    x, wi, wo = training_pairs(np.random.default_rng(0), samples)
    cosine = wi[:, 2:]
    f_cos = np.broadcast_to(np.asarray(f(wi, wo), np.float64), (len(wi), 3)) * cosine
    data = tuple(jnp.asarray(a, jnp.float32) for a in (x, f_cos, cosine))
    steps = len(x) // BATCH
    rule = optax.adam(optax.cosine_decay_schedule(RATE, passes * steps))
    weights = _initial(np.random.default_rng((0, 1)))
    state = weights, rule.init(weights)
    key = jax.random.key(0)
    for i in range(passes):
        state = _one_pass(rule, state, data, jax.random.fold_in(key, i))
    return Nbrdf(np.asarray(state[0]))


def training_pairs(
    rng: np.random.Generator, samples: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (N, 6), and float32 unit vectors wi, wo (N, 3) of the pairs above the horizon."""
    u = rng.random((3, samples))
    theta_h, theta_d, phi_d = u[0] ** 2 * (np.pi / 2), u[1] * (np.pi / 2), u[2] * np.pi
    wi, wo = (w.astype(np.float32) for w in directions_at(theta_h, theta_d, phi_d))
    above = np.minimum(wi[:, 2], wo[:, 2]) > 0
    return vectors(theta_h, theta_d, phi_d)[above], wi[above], wo[above]


def _initial(rng: np.random.Generator) -> jax.Array:
    """Initial weights by Glorot and Bengio 2010; biases are zero."""
    parts = [
        rng.uniform(-1, 1, shape) * np.sqrt(6 / sum(shape)) if len(shape) == 2 else np.zeros(shape)
        for shape in SHAPES
    ]
    return jnp.asarray(np.concatenate([part.ravel() for part in parts]), jnp.float32)


@partial(jax.jit, static_argnums=0)
def _one_pass(rule, state, data, key):
    """Use all samples once, in a new order."""
    count = len(data[0]) // BATCH
    order = jax.random.permutation(key, len(data[0]))[: count * BATCH].reshape(count, BATCH)

    def loss(weights, rows):
        x, f_cos, cosine = (array[rows] for array in data)
        f = jnp.expm1(logits(weights, x, jnp))
        return jnp.mean(jnp.abs(jnp.log1p(f * cosine) - jnp.log1p(f_cos)))

    def step(state, rows):
        weights, moments = state
        gradient = jax.grad(loss)(weights, rows)
        update, moments = rule.update(gradient, moments)
        return (optax.apply_updates(weights, update), moments), None

    return jax.lax.scan(step, state, order)[0]
