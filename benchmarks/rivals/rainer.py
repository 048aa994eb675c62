"""Neural BTFs of Rainer et al. 2019 and 2020, on single BRDFs.

Both decode a latent code and two directions to RGB by four hidden layers of 106 ReLU. In 2019
("Neural BTF Compression and Interpolation") every material has a decoder of its own; its encoder
gives a code to every texel. A single BRDF has one texel, hence one code, which is a parameter here:
no encoder could give a better one. In 2020 ("Unified Neural Encoding of BTFs") one encoder and one
decoder serve all materials. The encoder takes any number of measurements in any order.

The directions enter by their x and y, without half vectors: a texel's values depend on the azimuth
of both directions. Isotropic BRDFs are therefore turned at random in training, and exchanged.
Loss, output and samples are those of `nbrdf`, so that architectures alone are compared. The
publications' text on the encoder's layers was not at hand; its sizes are ours.
"""

from functools import partial
from types import ModuleType
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from benchmarks.rivals import nbrdf
from benchmarks.rivals.nbrdf import Brdf, Layers, initial, log_error, perceptron

from urushi.measured.tabulated import evaluate

#: Numbers of a code: of Rainer et al. 2019 and of Rainer et al. 2020.
LATENT_2019, LATENT_2020 = 8, 32
#: Hidden layers of the decoder, and their width.
LAYERS, WIDTH = 4, 106
#: Width of the hidden layers of the encoder of 2020: two for each measurement, one after the mean.
ENCODER = 128
#: Materials, measurements and decoded pairs of a step of the training of 2020.
MATERIALS, MEASURED, DECODED = 32, 128, 64
#: Initial rates of Adam of 2019 and 2020.
RATES = 3e-3, 2e-3


class NeuralBtf(NamedTuple):
    """A BRDF as the layers of a decoder and a latent code (L,)."""

    decoder: Layers
    code: np.ndarray

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """float32 (N, 3) [1/sr], without cosine, of unit vectors (N, 3)."""
        ln_f = partial(decode, self.decoder, self.code, xp=np)
        return evaluate(lambda *pair: np.maximum(np.expm1(ln_f(_planar(*pair))), 0), 3, wi, wo)


def decode(decoder: Layers, code: Any, x: Any, xp: ModuleType) -> Any:
    """ln(1 + f) (..., 3) of codes (..., L) and directions (..., 4), with NumPy or JAX."""
    shape = (*x.shape[:-1], code.shape[-1])
    return perceptron(decoder, xp.concatenate([xp.broadcast_to(code, shape), x], axis=-1), xp)


def _planar(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return np.concatenate([wi[:, :2], wo[:, :2]], axis=1).astype(np.float32)


def decoder(rng: np.random.Generator, latent: int) -> Layers:
    """An untrained decoder of codes of `latent` numbers."""
    return initial(rng, (latent + 4, *(WIDTH,) * LAYERS, 3))


def train(f: Brdf, *, passes: int, samples: int) -> NeuralBtf:
    """Train decoder and code of one BRDF, as Rainer et al. 2019 do for one material.

    samples: number of pairs of directions that are drawn.
    """
    own = decoder(np.random.default_rng((0, 1)), LATENT_2019)
    parameters = NeuralBtf(own, np.ones(LATENT_2019, np.float32))

    def loss(parameters: NeuralBtf, rows: Any, key: Any) -> Any:
        wi, wo, values = rows
        u = jax.random.uniform(key, (2, nbrdf.BATCH))
        x, cosine = _inputs(wi, wo, 2 * jnp.pi * u[0], u[1] < 0.5)
        return log_error(decode(*parameters, x, jnp), values, cosine)

    return nbrdf.by_passes(loss, parameters, nbrdf.training_data(f, samples), RATES[0], passes)


class Unified(NamedTuple):
    """The shared networks of Rainer et al. 2020."""

    first: Layers  # of the encoder, which see one measurement each
    second: Layers  # of the encoder after the mean over measurements
    decoder: Layers

    def encode(self, wi: np.ndarray, wo: np.ndarray, values: np.ndarray) -> NeuralBtf:
        """The BRDF of measurements: unit vectors (N, 3) and values (N, 3) [1/sr]."""
        code = _encode(self, _planar(wi, wo), values.astype(np.float32), np)
        return NeuralBtf(self.decoder, code)


def untrained() -> Unified:
    """The networks before training."""
    rng = np.random.default_rng((0, 1))
    first = initial(rng, (7, ENCODER, ENCODER))
    second = initial(rng, (ENCODER, ENCODER, LATENT_2020))
    return Unified(first, second, decoder(rng, LATENT_2020))


def train_unified(wi: np.ndarray, wo: np.ndarray, values: np.ndarray, *, steps: int) -> Unified:
    """Train the shared networks on materials.

    Args:
        wi, wo: (M, P, 3) unit vectors, other pairs for each material; P is larger than `MEASURED`.
        values: (M, P, 3) [1/sr].
        steps: number of steps of `MATERIALS` materials.
    """
    data, key = tuple(map(np.float32, (wi, wo, values))), jax.random.key(0)
    draws = (
        jax.random.split(jax.random.fold_in(key, start), min(100, steps - start))
        for start in range(0, steps, 100)
    )

    def loss(networks: Unified, data: Any, key: Any) -> Any:
        """The loss of drawn materials: codes of some of their pairs, decoded at others."""
        materials, pairs = data[0].shape[:2]
        draw, place, turn, exchange = jax.random.split(key, 4)
        rows = jax.random.randint(draw, (MATERIALS, 1), 0, materials)
        offset = jax.random.randint(place, (MATERIALS, 1), 0, pairs)
        columns = (offset + jnp.arange(MEASURED + DECODED)) % pairs
        wi, wo, values = (array[rows, columns] for array in data)
        angle = 2 * jnp.pi * jax.random.uniform(turn, columns.shape)
        x, cosine = _inputs(wi, wo, angle, jax.random.bernoulli(exchange, shape=columns.shape))
        code = _encode(networks, x[:, :MEASURED], values[:, :MEASURED], jnp)
        logits = decode(networks.decoder, code[:, None], x[:, MEASURED:], jnp)
        return log_error(logits, values[:, MEASURED:], cosine[:, MEASURED:])

    return nbrdf.minimised(loss, untrained(), data, draws, RATES[1], steps)


def _encode(networks: Unified, x: Any, values: Any, xp: ModuleType) -> Any:
    """Codes (..., L) of measurements: directions (..., N, 4) and values (..., N, 3)."""
    seen = xp.concatenate([x, xp.log1p(values)], axis=-1)
    hidden = xp.maximum(perceptron(networks.first, seen, xp), 0)
    return perceptron(networks.second, xp.mean(hidden, axis=-2), xp)


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
