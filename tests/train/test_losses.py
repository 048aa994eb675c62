"""The losses: gradients against finite differences, no bias under noise, composition of coats."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import COAT_FEATURES
from urushi.nets.layerer import layer
from urushi.train.examples import Batch
from urushi.train.losses import CYCLE_STRIDE, FLOOR, KNEE, compose, joint_loss, relative_error

ARCH = Architecture(latent=4, decoder=(8,), encoder=(8,), layerer=(8,), sampler=(4,), probes=6)


@pytest.fixture
def batch():
    rng = np.random.default_rng(0)
    count = CYCLE_STRIDE + 3  # two stacks take part in the cycle
    return Batch(
        probes=rng.random((count, 6), np.float32),
        coats=tuple(rng.standard_normal((n, COAT_FEATURES), np.float32) for n in (14, 5)),
        features=rng.standard_normal((count, 7, 8), np.float32),
        f=rng.random((count, 7), np.float32),
    )


def test_gradient_of_the_error_agrees_with_finite_differences(batch):
    with jax.enable_x64(True):
        rng = np.random.default_rng(1)
        params = {name: jnp.asarray(v, jnp.float64) for name, v in init(ARCH, 0).items()}
        along = {name: rng.standard_normal(v.shape) for name, v in params.items()}
        inputs = jax.tree.map(lambda x: jnp.asarray(x, jnp.float64), batch)

        def predict(p):
            z = compose(p, ARCH, inputs.probes, inputs.coats)
            return decode(p, ARCH, z[:, None], inputs.features)

        constant = jax.jit(predict)(params) + FLOOR  # what the loss holds constant

        @jax.jit
        def frozen(t):
            moved = {name: params[name] + t * along[name] for name in params}
            error = jnp.abs(predict(moved) - inputs.f) / constant
            return jnp.mean(jnp.where(error < KNEE, error**2, KNEE * (2 * error - KNEE)))

        gradient = jax.jit(jax.grad(lambda p: relative_error(predict(p), inputs.f)))(params)
        slope = sum(jnp.vdot(gradient[name], along[name]) for name in params)
        h = 1e-5  # central differences: error of order h^2
        assert float(slope) == pytest.approx(float((frozen(h) - frozen(-h)) / (2 * h)), rel=1e-5)


def test_every_trained_network_gets_a_gradient(batch):
    params = {name: jnp.asarray(value) for name, value in init(ARCH, 0).items()}
    features = jnp.asarray(np.random.default_rng(2).standard_normal((6, 8)), jnp.float32)
    slope = jax.jit(jax.grad(joint_loss, has_aux=True), static_argnums=1)
    gradient, terms = slope(params, ARCH, batch, features)
    for name, value in gradient.items():
        used = not name.startswith("sampler.")
        assert bool(jnp.any(value != 0)) == used, name
    assert all(np.isfinite(value) and value >= 0 for value in terms.values())


@pytest.mark.parametrize("spread", [0.3, 1.5])
def test_the_minimum_under_noise_is_the_mean(spread):
    # Gamma noise of mean 0.4 and the given relative deviation: skewed, like Monte Carlo values.
    rng = np.random.default_rng(3)
    shape = 1 / spread**2
    f = jnp.asarray(rng.gamma(shape, 0.4 / shape, 200_000), jnp.float32)
    slope = jax.jit(jax.grad(lambda log_f_hat: relative_error(jnp.exp(log_f_hat), f)))
    error = 2 * spread / np.sqrt(len(f))  # standard error of the slope at the mean
    assert abs(slope(jnp.log(0.4))) < 4 * error
    assert slope(jnp.log(0.4 * 1.05)) > 4 * error
    assert slope(jnp.log(0.4 * 0.95)) < -4 * error


def test_an_outlier_pulls_no_harder_than_the_knee():
    slope = jax.grad(lambda f_hat: relative_error(f_hat, jnp.float32(1e6)))
    # d/df_hat of KNEE (2 e - KNEE) with e = (f - f_hat) / (f_hat + FLOOR).
    assert slope(jnp.float32(1.0)) == pytest.approx(-2 * KNEE / (1 + FLOOR), rel=1e-5)


def test_compose_applies_the_lowest_coat_first(batch):
    params = init(ARCH, 0)
    z = np.asarray(jax.jit(compose, static_argnums=1)(params, ARCH, batch.probes, batch.coats))
    lowest, highest = batch.coats
    for row, probes in enumerate(batch.probes):
        code = encode(params, ARCH, probes)
        if row < len(lowest):
            code = layer(params, ARCH, code, lowest[row])
        if row < len(highest):
            code = layer(params, ARCH, code, highest[row])
        np.testing.assert_allclose(z[row], code, rtol=1e-4, atol=1e-5)
