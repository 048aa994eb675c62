"""The losses: gradients against finite differences, no bias under noise, composition of coats."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.core.error_metrics import FLOOR
from urushi.nets.architecture import Architecture, init
from urushi.nets.encoder import encode
from urushi.nets.layerer import layer
from urushi.nets.lobe import of_coat
from urushi.train.batches import Batch
from urushi.train.losses import (
    KNEE,
    LARGEST_CODE,
    compose,
    squared_errors,
    stack_loss,
    without_lobe,
)
from urushi.train.stages.joint import CYCLE_STRIDE, joint_loss

ARCH = Architecture(latent=10, decoder=(8,), encoder=(8,), layerer=(8,), sampler=(4,), probes=6)


def _coats(rng, count):
    low, high = np.array([[0.01, 1.05, 0, 0, -0.8], [1, 2, 1, 8, 0.9]], np.float32)
    return low + (high - low) * rng.random((count, 5), np.float32)


@pytest.fixture
def batch():
    rng = np.random.default_rng(0)
    count = CYCLE_STRIDE + 3  # two stacks are in the cycle loss
    return Batch(
        lobes=np.tile(of_coat(np.float32(0.3), np.float32(1.5)), (count, 1)),
        probes=rng.random((count, 6), np.float32),
        coats=tuple(_coats(rng, n) for n in (14, 5)),
        features=rng.standard_normal((count, 8, 8), np.float32),
        top=0.1 * rng.random((count, 8), np.float32),
        f=rng.random((count, 8), np.float32),
    )


def test_gradient_of_the_error_agrees_with_finite_differences(batch):
    with jax.enable_x64(True):
        rng = np.random.default_rng(1)
        params = {name: jnp.asarray(v, jnp.float64) for name, v in init(ARCH, 0).items()}
        along = {name: rng.standard_normal(v.shape) for name, v in params.items()}
        inputs = jax.tree.map(lambda x: jnp.asarray(x, jnp.float64), batch)

        def predict(p):
            z = compose(p, ARCH, inputs.lobes, inputs.probes, inputs.coats)
            return inputs.top + without_lobe(p, ARCH, z, inputs.features)

        decoded = jax.jit(predict)(params)
        brightness = jnp.pi * jnp.minimum(decoded, 1).mean(axis=-1, keepdims=True)
        assert float(brightness.min()) > 1  # so that the floor is not reduced
        constant = decoded + FLOOR  # what the loss holds constant

        @jax.jit
        def frozen(t):
            moved = {name: params[name] + t * along[name] for name in params}
            error = jnp.abs(predict(moved) - inputs.f) / constant
            return jnp.mean(jnp.where(error < KNEE, error**2, KNEE * (2 * error - KNEE)))

        def mean(p):
            return jnp.mean(squared_errors(predict(p), inputs.f))

        gradient = jax.jit(jax.grad(mean))(params)
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
    # 16 pairs a stack: if a weight depended on the noise of its own pairs, the minimum would be far
    # too dark at 1.5.
    rng = np.random.default_rng(3)
    shape = 1 / spread**2
    f = jnp.asarray(rng.gamma(shape, 0.4 / shape, (40_000, 16)), jnp.float32)

    @jax.jit
    @jax.vmap
    def slopes(f, log_f_hat):
        one_stack = jax.grad(lambda x: stack_loss(jnp.exp(x) + jnp.zeros((1, 16)), f[None]))
        return one_stack(log_f_hat)

    def slope(f_hat):
        of_stacks = np.asarray(slopes(f, jnp.full(len(f), np.log(f_hat), jnp.float32)))
        return of_stacks.mean(), of_stacks.std() / np.sqrt(len(f))

    mean, error = slope(0.4)
    assert abs(mean) < 4 * error
    assert slope(0.4 * 1.1)[0] > 4 * error
    assert slope(0.4 * 0.9)[0] < -4 * error


def test_the_gradient_of_an_outlier_is_bounded_by_the_knee():
    slope = jax.grad(lambda f_hat: squared_errors(f_hat[None], jnp.float32(1e6))[0])
    # d/df_hat of KNEE (2 e - KNEE) with e = (f - f_hat) / (f_hat + FLOOR).
    assert slope(jnp.float32(1.0)) == pytest.approx(-2 * KNEE / (1 + FLOOR), rel=1e-5)


def test_errors_of_dark_stacks_are_relative_to_their_brightness():
    # A stack ten times as dark has the same loss, as long as pi f is above the floor's least share.
    f = np.array([[0.2, 0.3], [0.02, 0.03]], np.float32)
    bright, dark = np.asarray(squared_errors(jnp.asarray(1.1 * f), f))
    np.testing.assert_allclose(bright, dark, rtol=1e-3)


def test_the_loss_of_a_stack_grows_with_about_the_root_of_its_error():
    f = jnp.ones((1, 16), jnp.float32)
    errors = np.array([0.2, 0.4, 0.8])
    losses = np.array([float(stack_loss(f * (1 + e), f)) for e in errors])
    relative = errors / (1 + errors + FLOOR)  # the loss is its square before weighting
    # EASE is a tenth of the least square, so that its root is 5 % more than without.
    np.testing.assert_allclose(losses / losses[2], relative / relative[2], rtol=0.06)


def test_compose_applies_the_lowest_coat_first(batch):
    params = init(ARCH, 0)
    composed = jax.jit(compose, static_argnums=1)
    z = np.asarray(composed(params, ARCH, batch.lobes, batch.probes, batch.coats))
    lowest, highest = batch.coats
    for row, probes in enumerate(batch.probes):
        code = np.concatenate([batch.lobes[row], encode(params, ARCH, probes)])
        if row < len(lowest):
            code = layer(params, ARCH, code, tuple(lowest[row]))
        if row < len(highest):
            code = layer(params, ARCH, code, tuple(highest[row]))
        np.testing.assert_allclose(z[row], code, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("outwards", [-1, 1])
def test_codes_beyond_their_bounds_are_clamped_and_can_return(batch, outwards):
    params = init(ARCH, 0)
    bias = np.full_like(params["encoder.1.bias"], 10 * LARGEST_CODE)

    def objective(bias):
        own = params | {"encoder.1.bias": bias}
        z = compose(own, ARCH, batch.lobes, batch.probes, ())
        return -outwards * z[0, ARCH.lobe]  # the minimum lies at large or at small codes

    assert float(objective(bias)) == pytest.approx(-outwards * LARGEST_CODE)
    assert float(jax.grad(objective)(bias)[0]) == (0 if outwards > 0 else 1)
