"""SOAP finds the eigenvectors of a curvature; compiled steps learn."""

import jax
import jax.numpy as jnp
import numpy as np
import optax

from urushi.train.optimiser import Schedule, compile_steps, soap, start


def least(rule, left, right, steps):
    """The loss |L W R|^2 after some steps from a random W: its minimum is zero, at zero."""
    left, right = (jnp.asarray(m, jnp.float32) for m in (left, right))
    rng = np.random.default_rng(1)
    weight = {"w": jnp.asarray(rng.standard_normal((12, 8)), jnp.float32)}

    @jax.jit
    def step(weight, state):
        loss, slope = jax.value_and_grad(lambda w: jnp.sum((left @ w["w"] @ right) ** 2))(weight)
        update, state = rule.update(slope, state, weight)
        return optax.apply_updates(weight, update), state, loss

    state = rule.init(weight)
    for _ in range(steps):
        weight, state, loss = step(weight, state)
    return float(loss)


def test_a_rotated_curvature_is_as_easy_as_one_along_the_axes():
    rng = np.random.default_rng(0)
    steep, flat = np.diag(np.logspace(-1.5, 1.5, 12)), np.diag(np.logspace(-0.5, 0.5, 8))
    first, last, right = (np.linalg.qr(rng.standard_normal((n, n)))[0] for n in (12, 12, 8))
    rotated, rate = (first @ steep @ last, right @ flat), optax.cosine_decay_schedule(0.02, 400)
    adam = optax.adam(rate, b1=0.95, b2=0.99)
    start_loss, found = least(soap(rate), *rotated, 1), least(soap(rate), *rotated, 400)
    assert found < 1e-4 * start_loss
    assert found < 0.1 * least(adam, *rotated, 400)
    assert found < 10 * max(least(adam, steep, flat, 400), 1e-6 * start_loss)


def test_matrices_and_biases_learn():
    schedule = Schedule(400, 10, 3e-2, average=0.9, steps_per_call=50, checkpoint_every=50)
    rng = np.random.default_rng(2)
    x = jnp.asarray(rng.standard_normal((64, 5)), jnp.float32)
    target = x @ jnp.asarray(rng.standard_normal((5, 3)), jnp.float32) + 1.5

    def loss(params, _):
        return jnp.mean((x @ params["weight"] + params["bias"] - target) ** 2)

    zeros = {"weight": np.zeros((5, 3), np.float32), "bias": np.zeros(3, np.float32)}
    state = start(zeros, schedule)
    steps, losses = compile_steps(loss, schedule), []
    for first in range(0, schedule.steps, 50):
        state, mean = steps(state, np.arange(first, first + 50, dtype=np.uint32))
        losses.append(float(mean))
    assert losses[-1] < 0.02 * losses[0]
