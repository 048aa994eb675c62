"""Jacobians agree with finite differences and with the automatic derivatives of JAX."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.nets import decoder, encoder
from urushi.nets.features import direction_features


@pytest.fixture(scope="module")
def double(networks):
    """The same networks in double precision, for finite differences."""
    arch, params = networks
    return arch, {name: value.astype(np.float64) for name, value in params.items()}


@pytest.fixture(scope="module")
def codes():
    return np.random.default_rng(3).normal(size=(3, 18))


@pytest.fixture(scope="module")
def features(pairs):
    return direction_features(*pairs)[::40].astype(np.float64)


@pytest.fixture(scope="module")
def logs():
    """Logarithmic values at the probe pairs, over the range of real BRDFs."""
    return np.random.default_rng(4).uniform(-6, 4, size=(3, 192))


def _compare(slopes, function, x):
    """Compare slopes (..., outputs, inputs) with central differences of a step of 1e-6.

    Their error is 1e-9. Both one-sided differences differ by the step times the second derivative,
    and by the jump of the slope where a ReLU's kink is within the step; there is no slope then.
    """
    here, kinks = function(x), 0
    for index in range(x.shape[-1]):
        step = np.zeros(x.shape[-1])
        step[index] = 1e-6
        above, below = (function(x + step) - here) / 1e-6, (here - function(x - step)) / 1e-6
        smooth = np.abs(above - below) < 1e-4
        kinks += np.count_nonzero(~smooth)
        central = 0.5 * (above + below)
        np.testing.assert_allclose(slopes[..., index][smooth], central[smooth], atol=1e-6)
    assert kinks < 0.01 * slopes.size


def test_decoder_against_differences(double, codes, features):
    arch, params = double
    log_f, slopes = decoder.decode_log(params, arch, codes[:, None], features)
    np.testing.assert_allclose(
        np.exp(log_f), decoder.decode(params, arch, codes[:, None], features), rtol=1e-12
    )
    _compare(slopes, lambda z: np.log(decoder.decode(params, arch, z[:, None], features)), codes)


def test_encoder_against_differences(double, logs):
    arch, params = double
    z, slopes = encoder.encode_log(params, arch, logs)
    f = np.exp(logs) - encoder.OFFSET
    np.testing.assert_allclose(z, encoder.encode(params, arch, f), atol=1e-9)
    _compare(slopes, lambda x: encoder.encode(params, arch, np.exp(x) - encoder.OFFSET), logs)


def test_against_automatic_differentiation(networks, codes, features, logs):
    arch, params = networks
    z, direction_inputs, x = (jnp.asarray(a, jnp.float32) for a in (codes, features, logs))

    def decoded(z, features):
        return jnp.log(decoder.decode(params, arch, z, features))

    def encoded(x):
        return encoder.encode(params, arch, jnp.exp(x) - encoder.OFFSET)

    ours = decoder.decode_log(params, arch, np.asarray(z)[:, None], np.asarray(direction_inputs))[1]
    theirs = jax.vmap(jax.vmap(jax.grad(decoded), (None, 0)), (0, None))(z, direction_inputs)
    # Single precision: sums of some hundred terms of size 1 to 10.
    np.testing.assert_allclose(ours, theirs, atol=2e-4, rtol=1e-3)
    ours = encoder.encode_log(params, arch, np.asarray(x))[1]
    np.testing.assert_allclose(ours, jax.vmap(jax.jacobian(encoded))(x), atol=2e-4, rtol=1e-3)


def test_one_definition_runs_on_jax(networks, codes, features):
    arch, params = networks
    z, direction_inputs = codes[:, None].astype(np.float32), features.astype(np.float32)
    ours = decoder.decode_log(params, arch, z, direction_inputs)
    theirs = jax.jit(lambda z, x: decoder.decode_log(params, arch, z, x))(z, direction_inputs)
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-4, rtol=1e-3)


def test_clamped_values_have_no_slope(networks, codes, features):
    arch, params = networks
    dark = codes[:, None].astype(np.float32)
    dark[..., 0] = -1000.0
    log_f, slopes = decoder.decode_log(params, arch, dark, features.astype(np.float32))
    assert (log_f == decoder.MIN_LOG).all() and not slopes.any()
