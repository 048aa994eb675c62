"""Neural BRDFs of 675 weights, one network for each material (Sztrajman et al. 2021).

Half and difference vectors (Rusinkiewicz 1998), as six numbers, pass two hidden layers of 21 ReLU.
"""

import itertools
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from benchmarks.rivals.perceptron import (
    Brdf,
    Layers,
    by_passes,
    initial,
    log_error,
    perceptron,
    training_data,
)

from urushi.core.directions import half_difference
from urushi.core.namespace import NUMPY, components
from urushi.measured.tabulated import evaluate

#: Widths of the layers, the inputs first; number of weights of a material.
SIZES = (6, 21, 21, 3)
SIZE = sum((a + 1) * b for a, b in itertools.pairwise(SIZES))
#: Passes over the samples, and initial rate of Adam; the authors' 100 passes at a constant rate of
#: 0.0005 are no better.
PASSES, RATE = 30, 5e-3


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


def train(f: Brdf, *, passes: int = PASSES, samples: int = 640_000) -> Nbrdf:
    """Train the network of a BRDF: 15 seconds of one core; samples: as in the authors' code."""
    wi, wo, values = training_data(f, samples)
    data = np.float32(inputs(wi, wo)), wi[:, 2:], values
    layers = initial(np.random.default_rng((0, 1)), SIZES)
    return Nbrdf(by_passes(_loss, layers, data, RATE, passes))


def _loss(layers: Layers, rows: Any, _: Any) -> Any:
    x, cosine, values = rows
    return log_error(perceptron(layers, x, jnp), values, cosine)
