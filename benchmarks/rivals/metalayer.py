"""The BSDFNet of MetaLayer (Guo et al. 2023), on single BRDFs.

"MetaLayer: A Meta-Learned BSDF Model for Layered Materials" evaluates each channel of a material by
a small network, the BSDFNet. Some of its numbers are the channel's own: units of the hidden layers
that do not depend on directions, and the weights of one unit of each layer. A large network, the
MetaNet, predicts them from the layers' parameters. All materials share the other weights. The
MetaNet knows parameters and no values, and its training took 50 hours of eight GPUs. Here a BRDF is
known by its values alone, so that all numbers are trained for the one BRDF. What is measured is
what the small network can hold after a short training, not how well a MetaNet predicts it.

The publication was not at hand. These facts are from a reader's detailed notes on it, and the code
of a public renderer has layers of the same sizes: 168 inputs, the half and the difference vector
with 81 spherical harmonics of each; five hidden layers of 64 units, the last of 32; over 13,000
weights; 293 numbers of a channel, which are 4 x 32 units, 5 x 32 weights and 5 biases; ReLU. The
order of layers below has all these sizes, and 13,468 common weights.

Assumed are this order, degrees 0 to 8 of harmonics, ReLU of a channel's own units (that code has
none there), the output ln(1 + f), the vectors' azimuths, the initial weights and the training.
Loss, output, rate and samples are those of `benchmarks.rivals.nbrdf`, so that architectures alone
are compared. The paper's loss is another one: a reversed Huber loss of compressed values.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
import optax
from benchmarks.rivals import nbrdf

from urushi.measured.tabulated import evaluate

#: Bands of spherical harmonics, degrees 0 to 8, and the inputs: two vectors and their harmonics.
BANDS = 9
INPUTS = 2 * (3 + BANDS * BANDS)

#: Units of a channel's own in each hidden layer but the last, all others, and hidden layers.
DIRECT, WIDTH, LAYERS = 32, 32, 5


class Weights(NamedTuple):
    """The numbers of a material; they may be those of NumPy or JAX."""

    first: tuple[Any, Any]  # weights (168, 32) and biases (32,) of the first hidden layer
    common: tuple[tuple[Any, Any], ...]  # (64, 31) and (31,) of each other hidden layer
    direct: Any  # (3, 4, 32) units of each channel, of all hidden layers but the last
    rows: Any  # (3, 5, 32) weights of each channel's own unit in layers 2 to 5, and of the output
    biases: Any  # (3, 5) their biases


@dataclass(frozen=True, eq=False)
class BsdfNet:
    """A BRDF as its own network.

    Attributes:
        weights: its numbers.
    """

    weights: Weights

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        x = encoded(nbrdf.inputs(wi, wo))
        return np.maximum(np.expm1(logits(self.weights, x, np)), 0)


def encoded(x: np.ndarray) -> np.ndarray:
    """The network's inputs, float32 (N, 168), of half and difference vectors (N, 6)."""
    half, difference = x[:, :3], x[:, 3:]
    parts = [half, difference, harmonics(half), harmonics(difference)]
    return np.concatenate(parts, axis=1).astype(np.float32)


def harmonics(w: np.ndarray) -> np.ndarray:
    """Real spherical harmonics (N, 81) of unit vectors (N, 3), orthonormal on the sphere.

    By degree l from 0 to 8, and in it by order m from -l to l.
    """
    x, y, z = w.T
    # P[l, m] is the associated Legendre function over sin^m, which is a polynomial of z.
    legendre: dict[tuple[int, int], Any] = {}
    azimuth = [np.ones_like(x) + 0j]  # (sin theta e^(i phi))^m
    found = np.empty((len(w), BANDS * BANDS))
    for m in range(BANDS):
        legendre[m, m] = legendre[m - 1, m - 1] * (2 * m - 1) if m else np.ones_like(z)
        for degree in range(m + 1, BANDS):
            before = legendre.get((degree - 2, m), 0)
            above = (2 * degree - 1) * z * legendre[degree - 1, m] - (degree + m - 1) * before
            legendre[degree, m] = above / (degree - m)
        if m:
            azimuth.append(azimuth[-1] * (x + 1j * y))
    for (degree, m), value in legendre.items():
        product = float(np.prod(np.arange(degree - m + 1, degree + m + 1, dtype=float)))
        scale = np.sqrt((2 * degree + 1) / (4 * np.pi) / product) * (np.sqrt(2) if m else 1)
        centre = degree * (degree + 1)
        found[:, centre + m] = scale * value * azimuth[m].real
        if m:
            found[:, centre - m] = scale * value * azimuth[m].imag
    return found


def logits(weights: Weights, x: Any, xp: ModuleType) -> Any:
    """ln(1 + f) by channel (N, 3), of inputs (N, 168), with NumPy or JAX."""
    matrix, bias = weights.first
    hidden = xp.maximum(x @ matrix + bias, 0)[:, None]  # (N, 1 or 3, 32)
    for layer, (matrix, bias) in enumerate(weights.common):
        # The channel's units are constant, so that their part is a bias.
        own_bias = weights.direct[:, layer] @ matrix[:DIRECT] + bias
        common = xp.maximum(hidden @ matrix[DIRECT:] + own_bias, 0)
        own = xp.maximum(_own_unit(weights, hidden, layer), 0)
        hidden = xp.concatenate([common, own[..., None]], axis=-1)
    return _own_unit(weights, hidden, LAYERS - 1)


def _own_unit(weights: Weights, hidden: Any, layer: int) -> Any:
    """A channel's own unit (N, 3) after the units (N, 1 or 3, 32) of a layer."""
    return (hidden * weights.rows[:, layer]).sum(axis=-1) + weights.biases[:, layer]


def size(weights: Weights) -> tuple[int, int]:
    """Number of common weights, and of those of all three channels."""
    common, own = jax.tree.leaves(weights[:2]), weights[2:]
    return sum(array.size for array in common), sum(array.size for array in own)


def initial(rng: np.random.Generator) -> Weights:
    """Initial weights by Glorot and Bengio 2010; biases are zero, a channel's units normal."""

    def uniform(*shape: int, fan: int) -> np.ndarray:
        return np.float32(rng.uniform(-1, 1, shape) * np.sqrt(6 / fan))

    def zeros(*shape: int) -> np.ndarray:
        return np.zeros(shape, np.float32)

    units = DIRECT + WIDTH
    first = uniform(INPUTS, WIDTH, fan=INPUTS + WIDTH), zeros(WIDTH)
    common = tuple(
        (uniform(units, WIDTH - 1, fan=units + WIDTH - 1), zeros(WIDTH - 1))
        for _ in range(LAYERS - 1)
    )
    direct = np.float32(rng.normal(size=(3, LAYERS - 1, DIRECT)))
    rows = uniform(3, LAYERS, WIDTH, fan=WIDTH + 1)
    return Weights(first, common, direct, rows, zeros(3, LAYERS))


def train(
    f: Callable[[np.ndarray, np.ndarray], np.ndarray],
    *,
    passes: int,
    samples: int,
    seed: int = 0,
) -> BsdfNet:
    """Train the network of one BRDF.

    Args:
        f: f(wi, wo) -> (N, 3) or (N, 1) [1/sr] for float32 unit vectors (N, 3).
        passes: number of passes over all samples.
        samples: number of pairs of directions that are drawn.
        seed: seed of samples, their order and the initial weights.
    """
    x, wi, wo = nbrdf.training_pairs(np.random.default_rng(seed), samples)
    cosine = wi[:, 2:]
    f_cos = np.broadcast_to(np.asarray(f(wi, wo), np.float64), (len(wi), 3)) * cosine
    data = tuple(jnp.asarray(a, jnp.float32) for a in (encoded(x), f_cos, cosine))
    rule = optax.adam(optax.cosine_decay_schedule(nbrdf.RATE, passes * (len(x) // nbrdf.BATCH)))
    weights = jax.tree.map(jnp.asarray, initial(np.random.default_rng((seed, 1))))
    state = weights, rule.init(weights)
    key = jax.random.key(seed)
    for i in range(passes):
        state = _one_pass(rule, state, data, jax.random.fold_in(key, i))
    return BsdfNet(jax.tree.map(np.asarray, state[0]))


@partial(jax.jit, static_argnums=0)
def _one_pass(rule: Any, state: Any, data: Any, key: Any) -> Any:
    """Use all samples once, in a new order."""
    count = len(data[0]) // nbrdf.BATCH
    order = jax.random.permutation(key, len(data[0]))[: count * nbrdf.BATCH].reshape(
        count, nbrdf.BATCH
    )

    def loss(weights: Weights, rows: Any) -> Any:
        x, f_cos, cosine = (array[rows] for array in data)
        f = jnp.expm1(logits(weights, x, jnp))
        return jnp.mean(jnp.abs(jnp.log1p(f * cosine) - jnp.log1p(f_cos)))

    def step(state: Any, rows: Any) -> tuple[Any, None]:
        weights, moments = state
        gradient = jax.grad(loss)(weights, rows)
        update, moments = rule.update(gradient, moments)
        return (optax.apply_updates(weights, update), moments), None

    return jax.lax.scan(step, state, order)[0]
