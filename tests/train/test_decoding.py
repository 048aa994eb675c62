"""The decoding stage: it learns the scatter, gives such pairs less weight, and adds no bias."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.core.error_metrics import FLOOR
from urushi.nets.architecture import FIXED, Architecture, init
from urushi.nets.lobe import NO_LOBE
from urushi.train.batches import Batch
from urushi.train.losses import mean_loss, squared_errors
from urushi.train.optimiser import Schedule, compile_steps, start
from urushi.train.stages import decoding
from urushi.train.stages.decoding import (
    fresh_scatter,
    negative_log_likelihood,
    scatter,
    scatter_weights,
    weighted_loss,
)

#: Each compiles a training step for seconds.
pytestmark = pytest.mark.research

ARCH = Architecture(latent=10, decoder=(8,), encoder=(8,), layerer=(8,), sampler=(4,), probes=6)


def _split(params):
    trained = {k: v for k, v in params.items() if k.startswith("decoder")}
    return trained | fresh_scatter(ARCH, 1), {k: v for k, v in params.items() if k not in trained}


@pytest.fixture
def batch():
    rng = np.random.default_rng(0)
    return Batch(
        lobes=np.tile(np.array(NO_LOBE, np.float32), (12, 1)),
        probes=rng.random((12, 6), np.float32),
        coats=(np.array([[0.2, 1.5, 0.5, 1.0, 0.3]] * 5, np.float32),),
        features=rng.standard_normal((12, 16, 8), np.float32),
        top=np.zeros((12, 16), np.float32),
        f=rng.random((12, 16), np.float32),
    )


def test_the_likeliest_scatter_is_the_mean_of_the_squares():
    # Squares of a Gaussian's errors: a mean over 4e5 of them is known to 0.4 %.
    squares = np.random.default_rng(1).normal(0, 0.1, (1, 400_000)) ** 2
    at = jax.jit(lambda v: negative_log_likelihood(jnp.full(squares.shape, v), squares))
    guesses = squares.mean() * np.array([0.95, 1.0, 1.05])
    below, there, above = map(float, map(at, guesses))
    assert there < min(below, above)


def test_scatter_that_differs_by_direction_and_code_is_learnt():
    # The root of the mean square is 0.05 or 0.4 by a feature's sign, and twice that by the code's.
    rng = np.random.default_rng(2)
    steps, stacks, pairs = 50, 32, 64
    schedule = Schedule(
        800, 20, 5e-3, average=0.98, steps_per_call=50, checkpoint_every=50, rule="soap"
    )

    def drawn():
        z = rng.standard_normal((steps, stacks, ARCH.latent), np.float32)
        features = rng.standard_normal((steps, stacks, pairs, 8), np.float32)
        return z, features, deviation(z, features)

    def deviation(z, features):
        by_code = np.where(z[..., ARCH.lobe + 1] > 0, 2.0, 1.0)[..., None]
        return by_code * np.where(features[..., 2] > 0, 0.4, 0.05)

    def loss(params, batch):
        z, features, error = batch
        value = negative_log_likelihood(scatter(params, ARCH, z, features), error**2)
        return value, {"loss": value}

    state, run = start(fresh_scatter(ARCH, 3), schedule), compile_steps(loss, schedule)
    for _ in range(schedule.steps // steps):
        z, features, sigma = drawn()
        errors = (sigma * rng.standard_normal(sigma.shape)).astype(np.float32)
        state, _ = run(state, (z, features, errors))
    z, features, sigma = (x[0] for x in drawn())
    clear = (np.abs(z[..., ARCH.lobe + 1]) > 0.5)[:, None] & (np.abs(features[..., 2]) > 0.5)
    found = np.sqrt(np.asarray(scatter(state.average, ARCH, z, features)))
    off = np.abs(np.log(found / sigma))[clear]  # a smooth network rounds the steps between
    assert np.median(off) < 0.2
    assert np.percentile(off, 95) < 0.7


def test_weights_have_mean_one_and_fall_with_the_scatter():
    values = jnp.array([[1e-4, 1e-2, 1.0, 4.0], [1e-9, 1e-9, 1e-9, 1e-9]])
    weights = np.asarray(scatter_weights(values))
    np.testing.assert_allclose(weights.mean(axis=1), 1.0, rtol=1e-6)
    assert (np.diff(weights[0]) < 0).all()
    np.testing.assert_allclose(weights[1], 1.0, rtol=1e-6)
    # Four times the scatter gives half the weight, if both are far above the least scatter.
    assert weights[0, 2] / weights[0, 3] == pytest.approx(2.0, rel=1e-4)


def test_gains_do_not_change_the_scatter(batch):
    rng = np.random.default_rng(4)
    z = jnp.asarray(rng.standard_normal((12, ARCH.latent)), jnp.float32)
    params = fresh_scatter(ARCH, 1)
    brighter = z.at[:, ARCH.lobe].add(2.0)
    np.testing.assert_array_equal(
        scatter(params, ARCH, brighter, batch.features), scatter(params, ARCH, z, batch.features)
    )


def test_decoder_and_scatter_get_no_gradient_from_each_others_loss(batch):
    trained, others = _split(init(ARCH, 0))
    slope = jax.jit(jax.grad(weighted_loss, has_aux=True), static_argnums=2)
    gradient, terms = slope(trained, others, ARCH, batch)
    assert all(bool(jnp.any(value != 0)) for value in gradient.values())
    assert float(terms["fit"]) > 0

    def unlikely(trained):
        return weighted_loss(trained, others, ARCH, batch)[1]["scatter"]

    def fit(trained):
        return weighted_loss(trained, others, ARCH, batch)[1]["fit"]

    by_scatter, by_fit = jax.jit(jax.grad(unlikely))(trained), jax.jit(jax.grad(fit))(trained)
    for name in trained:
        assert not bool(jnp.any((by_scatter if name.startswith("decoder") else by_fit)[name] != 0))


def test_the_fit_of_two_known_errors(batch, monkeypatch):
    """Networks of zero weights decode to 1; errors alternate between 0.1 and 0.2, four pairs each.

    With TYPICAL = 0.01 and EASE = 0.003, each half weighted by the error of the other, the loss is
    (0.1^2 sqrt(0.01 / (0.003 + 0.2^2)) + 0.2^2 sqrt(0.01 / (0.003 + 0.1^2))) / 2 = 0.019952.
    """
    params = {k: v if k in FIXED else np.zeros_like(v) for k, v in init(ARCH, 0).items()}
    error = np.tile(np.repeat([0.1, 0.2], 4), (12, 2)).astype(np.float32)
    f = 1 - (1 + FLOOR) * error
    monkeypatch.setattr(decoding, "scatter_weights", jnp.ones_like)
    trained = {**params, **fresh_scatter(ARCH, 0)}
    fit = weighted_loss(trained, params, ARCH, batch._replace(f=f))[1]["fit"]
    assert float(fit) == pytest.approx(0.019952, rel=1e-4)


@pytest.mark.parametrize("spread", [0.3, 1.0])
def test_the_minimum_under_uneven_noise_is_the_mean(spread):
    # Gamma noise, four times as wide in every other pair, and weights of the true variance.
    rng = np.random.default_rng(5)
    deviations = np.tile([spread / 4, spread], 8)
    shape = 1 / deviations**2
    f = jnp.asarray(rng.gamma(shape, 0.4 / shape, (40_000, 16)), jnp.float32)
    weights = scatter_weights(jnp.asarray(deviations**2, jnp.float32)[None])

    @jax.jit
    @jax.vmap
    def slopes(f, log_f_hat):
        def one_stack(x):
            squares = squared_errors(jnp.exp(x) + jnp.zeros((1, 16)), f[None])
            return mean_loss(squares, weights)

        return jax.grad(one_stack)(log_f_hat)

    def slope(f_hat):
        of_stacks = np.asarray(slopes(f, jnp.full(len(f), np.log(f_hat), jnp.float32)))
        return of_stacks.mean(), of_stacks.std() / np.sqrt(len(f))

    mean, error = slope(0.4)
    assert abs(mean) < 4 * error
    assert slope(0.4 * 1.05)[0] > 4 * error
    assert slope(0.4 * 0.95)[0] < -4 * error
