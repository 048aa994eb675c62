"""One definition, two libraries: every network function agrees between NumPy and JAX under jit."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.nets import decoder, encoder, features, layerer, proposal, sampler
from urushi.nets.architecture import ACTIVATIONS
from urushi.nets.mlp import with_slope


@pytest.fixture(scope="module")
def vectors(draw_codes):
    """Golden random inputs: 40 codes, probe values over nine decades, coats, uniform numbers."""
    rng = np.random.default_rng(17)
    count = 40
    low = np.array([0.01, 0.5, 0, 0, -0.9])
    high = np.array([1, 3, 1, 8, 0.9])
    return {
        "z": draw_codes(count, rng).astype(np.float32),
        "f": np.exp(rng.uniform(-12, 8, size=(count, 192))).astype(np.float32),
        "coat": (low + (high - low) * rng.random((count, 5))).T.astype(np.float32),
        "u": rng.random((2003, 3), np.float32),
    }


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


def test_direction_features(pairs):
    # The steepest feature, sin^(1/2), turns the 1e-7 of a fused multiply-add at sin = 1e-4 into
    # 1e-5; normalisation triples it.
    _close(_both(features.direction_features, *pairs), atol=1e-4)


def test_features_of_coats(vectors):
    _close(_both(features.coat_features, *vectors["coat"]), atol=1e-5)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_activations(activation):
    x = np.linspace(-20, 20, 1001, dtype=np.float32)
    _close(_both(lambda x: with_slope(x, activation), x), atol=1e-5, rtol=1e-5)


def test_decode(networks, vectors, pairs):
    arch, params = networks
    inputs = features.direction_features(*pairs)[None, :300]
    # 32-bit sums of some hundred terms of size 1 differ by 1e-5; exp turns that into 1e-5
    # relative, times the output's gain of 8.
    _close(
        _both(lambda z, x: decoder.decode(params, arch, z[:, None, 6:], x), vectors["z"], inputs),
        atol=0, rtol=3e-4,
    )  # fmt: skip


def test_encode(networks, vectors):
    arch, params = networks
    _close(_both(lambda f: encoder.encode(params, arch, f), vectors["f"]), atol=3e-5)


def test_layer(networks, vectors):
    arch, params = networks
    _close(
        _both(lambda z, *c: layerer.layer(params, arch, z, c), vectors["z"], *vectors["coat"]),
        atol=3e-5,
    )


def test_lobes_parameters(networks, vectors, pairs):
    arch, params = networks
    wi = pairs[0][:40]
    _close(_both(lambda z, w: sampler.mixture(params, arch, z, w), vectors["z"], wi), atol=1e-4)


def test_lobes_pdf(pairs):
    weights = np.array([0.5, 0.3, 0.2], np.float32)
    alphas = np.array([0.05, 0.6], np.float32)
    # Rounding of wi + wo (1e-7) against the lobe's width of 0.05 in h at grazing angles (|h| of
    # 1e-3): 2e-3 relative at worst.
    _close(_both(proposal.mixture_pdf, weights, alphas, *pairs), atol=1e-5, rtol=5e-3)


def test_lobes_sample(vectors, pairs):
    weights = np.array([0.5, 0.3, 0.2], np.float32)
    alphas = np.array([0.05, 0.6], np.float32)
    # sqrt(1 - z^2) near z = 1 magnifies rounding: sqrt(1e-7) = 3e-4, times alpha.
    _close(_both(proposal.sample_mixture, weights, alphas, pairs[0], vectors["u"]), atol=1e-3)


def test_gradients_are_finite(networks, vectors, pairs):
    arch, params = networks
    inputs = features.direction_features(*pairs)[None]

    def loss(p, f, coat):
        rest = encoder.encode(p, arch, f)
        bottom = jnp.concatenate([jnp.asarray(vectors["z"][:, :6]), rest], axis=-1)
        z = layerer.layer(p, arch, bottom, tuple(coat))
        weights, alphas = sampler.mixture(p, arch, z[:, None], jnp.asarray(pairs[0][:, 2]))
        density = proposal.mixture_pdf(
            weights, alphas, jnp.asarray(pairs[0]), jnp.asarray(pairs[1])
        )
        return jnp.mean(decoder.decode(p, arch, z[:, None, 6:], inputs)) + jnp.mean(density)

    trained = {name: jnp.asarray(value) for name, value in params.items()}
    coat = jnp.asarray(vectors["coat"])
    gradient = jax.jit(jax.grad(loss))(trained, jnp.asarray(vectors["f"]), coat)
    assert all(bool(jnp.isfinite(g).all()) for g in gradient.values())
