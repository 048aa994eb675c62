"""Neural BTFs of Rainer et al. 2019 and 2020, on single BRDFs.

Both decode a latent code and two directions to RGB by four hidden layers of 106 ReLU. In 2019
("Neural BTF Compression and Interpolation") every material has a decoder of its own; its encoder
gives a code to every texel. A single BRDF has one texel, hence one code, which is a parameter here:
no encoder could give a better one. In 2020 ("Unified Neural Encoding of BTFs") one encoder and one
decoder serve all materials. The encoder takes any number of measurements in any order.

The directions enter by their x and y, without half vectors: a texel's values depend on the azimuth
of both directions. Isotropic BRDFs are therefore turned at random in training, and exchanged.
Loss, output and samples are those of `benchmarks.rivals.nbrdf`, so that architectures alone are
compared. The publications' text on the encoder's layers was not at hand; its sizes are ours.
"""

import itertools
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
from benchmarks.rivals.nbrdf import training_pairs

from urushi.measured.tabulated import evaluate

#: Numbers of a code: of Rainer et al. 2019 and of Rainer et al. 2020.
LATENT_2019, LATENT_2020 = 8, 32

#: Hidden layers of the decoder, and their width.
LAYERS, WIDTH = 4, 106

#: Width of the hidden layers of the encoder of 2020: two for each measurement, one after the mean.
ENCODER = 128

#: Samples per step of the training of 2019; materials, measurements and decoded pairs of 2020.
BATCH, MATERIALS, MEASURED, DECODED = 512, 32, 128, 64

#: Initial rates of Adam of 2019 and 2020; they decay as half a cosine.
RATES = 3e-3, 2e-3

#: f(wi, wo) -> (N, 3) [1/sr] for float32 unit vectors (N, 3).
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]
#: Weights (inputs, outputs) and bias (outputs,) of each layer.
Layers = tuple[tuple[Any, Any], ...]


@dataclass(frozen=True, eq=False)
class NeuralBtf:
    """A BRDF as a code and a decoder.

    Attributes:
        decoder: its layers; `WIDTH` hidden units in `LAYERS` layers, RGB.
        code: (L,) the latent code.
    """

    decoder: Layers
    code: np.ndarray

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        x = np.concatenate([wi[:, :2], wo[:, :2]], axis=1).astype(np.float32)
        return np.maximum(np.expm1(decode(self.decoder, self.code, x, np)), 0)


def decode(decoder: Layers, code: Any, x: Any, xp: ModuleType) -> Any:
    """ln(1 + f) (..., 3) of codes (..., L) and directions (..., 4), with NumPy or JAX."""
    shape = (*x.shape[:-1], code.shape[-1])
    return perceptron(decoder, xp.concatenate([xp.broadcast_to(code, shape), x], axis=-1), xp)


def perceptron(layers: Layers, x: Any, xp: ModuleType) -> Any:
    """Layers with ReLU between them."""
    for i, (weights, bias) in enumerate(layers):
        x = x @ weights + bias
        x = x if i == len(layers) - 1 else xp.maximum(x, 0)
    return x


def decoder_sizes(latent: int) -> tuple[int, ...]:
    """Widths of the decoder's layers, its inputs first."""
    return (latent + 4, *(WIDTH,) * LAYERS, 3)


def size(layers: Layers) -> int:
    """Number of weights and biases."""
    return sum(weights.size + bias.size for weights, bias in layers)


def initial(rng: np.random.Generator, sizes: tuple[int, ...]) -> Layers:
    """Initial layers by Glorot and Bengio 2010; biases are zero."""
    return tuple(
        (
            np.float32(rng.uniform(-1, 1, shape) * np.sqrt(6 / sum(shape))),
            np.zeros(shape[1], np.float32),
        )
        for shape in itertools.pairwise(sizes)
    )


def train(f: Brdf, *, passes: int, samples: int) -> NeuralBtf:
    """Train decoder and code of one BRDF, as Rainer et al. 2019 do for one material.

    Args:
        f: the BRDF.
        passes: number of passes over all samples.
        samples: number of pairs of directions that are drawn.
    """
    _, wi, wo = training_pairs(np.random.default_rng(0), samples)
    values = np.broadcast_to(np.asarray(f(wi, wo), np.float32), (len(wi), 3))
    data = tuple(jnp.asarray(a) for a in (wi, wo, values))
    decoder = initial(np.random.default_rng((0, 1)), decoder_sizes(LATENT_2019))
    rule = optax.adam(optax.cosine_decay_schedule(RATES[0], passes * (len(wi) // BATCH)))
    parameters = jax.tree.map(jnp.asarray, (decoder, np.ones(LATENT_2019, np.float32)))
    state = parameters, rule.init(parameters)
    key = jax.random.key(0)
    for i in range(passes):
        state = _one_pass(rule, state, data, jax.random.fold_in(key, i))
    return NeuralBtf(*jax.tree.map(np.asarray, state[0]))


@dataclass(frozen=True, eq=False)
class Unified:
    """The shared networks of Rainer et al. 2020.

    Attributes:
        first: layers of the encoder that see one measurement each.
        second: layers of the encoder after the mean over measurements.
        decoder: layers of the decoder.
    """

    first: Layers
    second: Layers
    decoder: Layers

    def encode(self, wi: np.ndarray, wo: np.ndarray, values: np.ndarray) -> NeuralBtf:
        """The BRDF of measurements: unit vectors (N, 3) and values (N, 3) [1/sr]."""
        x = np.concatenate([wi[:, :2], wo[:, :2]], axis=1).astype(np.float32)
        code = _encode((self.first, self.second), x, values.astype(np.float32), np)
        return NeuralBtf(self.decoder, code)


def train_unified(wi: np.ndarray, wo: np.ndarray, values: np.ndarray, *, steps: int) -> Unified:
    """Train the shared networks on materials.

    Args:
        wi, wo: (M, P, 3) unit vectors, other pairs for each material; P is larger than `MEASURED`.
        values: (M, P, 3) [1/sr].
        steps: number of steps of `MATERIALS` materials.
    """
    rng = np.random.default_rng((0, 1))
    first = initial(rng, (7, ENCODER, ENCODER))
    second = initial(rng, (ENCODER, ENCODER, LATENT_2020))
    decoder = initial(rng, decoder_sizes(LATENT_2020))
    parameters = jax.tree.map(jnp.asarray, (first, second, decoder))
    rule = optax.adam(optax.cosine_decay_schedule(RATES[1], steps))
    state = parameters, rule.init(parameters)
    data = tuple(jnp.asarray(a, jnp.float32) for a in (wi, wo, values))
    key = jax.random.key(0)
    for start in range(0, steps, 100):
        keys = jax.random.split(jax.random.fold_in(key, start), min(100, steps - start))
        state = _steps(rule, state, data, keys)
    return Unified(*jax.tree.map(np.asarray, state[0]))


def _encode(encoder: tuple[Layers, Layers], x: Any, values: Any, xp: ModuleType) -> Any:
    """Codes (..., L) of measurements: directions (..., N, 4) and values (..., N, 3)."""
    first, second = encoder
    seen = xp.concatenate([x, xp.log1p(values)], axis=-1)
    hidden = xp.maximum(perceptron(first, seen, xp), 0)
    return perceptron(second, xp.mean(hidden, axis=-2), xp)


def _inputs(wi: Any, wo: Any, angle: Any, exchanged: Any) -> tuple[Any, Any]:
    """Directions (..., 4) and the cosine of the first one (..., 1) of pairs (..., 3).

    angle, exchanged: (...) azimuth by which a pair is turned, and whether it is exchanged.
    """
    cos, sin = jnp.cos(angle), jnp.sin(angle)
    first = jnp.where(exchanged[..., None], wo, wi)
    second = jnp.where(exchanged[..., None], wi, wo)
    planar = [
        part
        for w in (first, second)
        for part in (cos * w[..., 0] - sin * w[..., 1], sin * w[..., 0] + cos * w[..., 1])
    ]
    return jnp.stack(planar, axis=-1), first[..., 2:]


def _loss(logits: Any, values: Any, cosine: Any) -> Any:
    """Mean of |ln(1 + f' cos) - ln(1 + f cos)| (Sztrajman et al. 2021)."""
    return jnp.mean(jnp.abs(jnp.log1p(jnp.expm1(logits) * cosine) - jnp.log1p(values * cosine)))


def _updated(rule: Any, state: Any, loss: Callable[[Any], Any]) -> Any:
    parameters, moments = state
    update, moments = rule.update(jax.grad(loss)(parameters), moments)
    return optax.apply_updates(parameters, update), moments


@partial(jax.jit, static_argnums=0)
def _one_pass(rule: Any, state: Any, data: Any, key: Any) -> Any:
    """Use all samples once, in a new order."""
    count = len(data[0]) // BATCH
    keys = jax.random.split(key, count + 1)
    order = jax.random.permutation(keys[0], len(data[0]))[: count * BATCH].reshape(count, BATCH)

    def step(state: Any, drawn: Any) -> tuple[Any, None]:
        rows, key = drawn
        wi, wo, values = (array[rows] for array in data)
        u = jax.random.uniform(key, (2, BATCH))
        x, cosine = _inputs(wi, wo, 2 * jnp.pi * u[0], u[1] < 0.5)

        def loss(parameters: Any) -> Any:
            return _loss(decode(*parameters, x, jnp), values, cosine)

        return _updated(rule, state, loss), None

    return jax.lax.scan(step, state, (order, keys[1:]))[0]


@partial(jax.jit, static_argnums=0)
def _steps(rule: Any, state: Any, data: Any, keys: Any) -> Any:
    """One step of the shared networks for each key."""
    materials, pairs = data[0].shape[:2]

    def step(state: Any, key: Any) -> tuple[Any, None]:
        draw, place, turn, exchange = jax.random.split(key, 4)
        rows = jax.random.randint(draw, (MATERIALS, 1), 0, materials)
        offset = jax.random.randint(place, (MATERIALS, 1), 0, pairs)
        columns = (offset + jnp.arange(MEASURED + DECODED)) % pairs
        wi, wo, values = (array[rows, columns] for array in data)
        angle = 2 * jnp.pi * jax.random.uniform(turn, columns.shape)
        x, cosine = _inputs(wi, wo, angle, jax.random.bernoulli(exchange, shape=columns.shape))

        def loss(parameters: Any) -> Any:
            *encoder, decoder = parameters
            code = _encode(tuple(encoder), x[:, :MEASURED], values[:, :MEASURED], jnp)
            logits = decode(decoder, code[:, None], x[:, MEASURED:], jnp)
            return _loss(logits, values[:, MEASURED:], cosine[:, MEASURED:])

        return _updated(rule, state, loss), None

    return jax.lax.scan(step, state, keys)[0]
