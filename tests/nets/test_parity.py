"""One definition, two libraries: what training needs agrees between NumPy and JAX under jit."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import untrained

from urushi.nets import features, layerer
from urushi.nets.mlp import POLYNOMIALS, activate


@pytest.fixture(scope="module")
def model():
    return untrained(functions=18)


@pytest.fixture(scope="module")
def vectors(random_lobes):
    """Golden random inputs: 40 codes and coats."""
    rng = np.random.default_rng(17)
    count = 40
    low = np.array([0.01, 0.5, 0, 0, -0.9])
    high = np.array([1, 3, 1, 8, 0.9])
    z = np.concatenate([random_lobes(count, rng), rng.normal(size=(count, 18))], axis=-1)
    coats = low + (high - low) * rng.random((count, 5))
    return {"z": z.astype(np.float32), "coat": coats.T.astype(np.float32)}


def _both(function, *arrays):
    """Results (tuples) of the function on NumPy arrays and, compiled, on JAX arrays."""

    def as_tuple(*args):
        result = function(*args)
        return result if isinstance(result, tuple) else (result,)

    ours = as_tuple(*arrays)
    theirs = jax.jit(as_tuple)(*(jnp.asarray(a) for a in arrays))
    for x, y in zip(ours, theirs, strict=True):
        assert isinstance(x, np.ndarray) and x.dtype == np.float32
        assert isinstance(y, jax.Array) and y.dtype == jnp.float32 and x.shape == y.shape
    return [(x, np.asarray(y)) for x, y in zip(ours, theirs, strict=True)]


def _close(results, atol, rtol=0.0):
    for ours, theirs in results:
        np.testing.assert_allclose(ours, theirs, atol=atol, rtol=rtol)


def test_features_of_coats(vectors):
    _close(_both(features.coat_features, *vectors["coat"]), atol=1e-5)


@pytest.mark.parametrize("activation", POLYNOMIALS)
def test_activations(activation):
    x = np.linspace(-20, 20, 1001, dtype=np.float32)
    _close(_both(lambda x: activate(x, activation), x), atol=1e-5, rtol=1e-5)


def test_layer(model, vectors):
    arch, params = model.arch, model.params
    _close(
        _both(lambda z, *c: layerer.layer(params, arch, z, c), vectors["z"], *vectors["coat"]),
        atol=3e-5,
    )


def test_gradients_are_finite(model, vectors):
    def loss(params, z, coat):
        return jnp.mean(layerer.layer(params, model.arch, z, tuple(coat)))

    trained = {name: jnp.asarray(x) for name, x in model.params.items() if "layerer" in name}
    gradient = jax.jit(jax.grad(loss))(trained, *map(jnp.asarray, vectors.values()))
    assert all(bool(jnp.isfinite(g).all()) for g in gradient.values())
