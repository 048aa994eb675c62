"""Joint training of the evaluation network and the latent codes of all training BRDFs."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from urushi.nets.architecture import Params
from urushi.nets.paper.architecture import FIRST_LATENT, LATENT
from urushi.nets.paper.evaluation import direction_inputs, evaluate
from urushi.train.paper.stream import Batch

#: Adam's constants (Kingma and Ba 2015), the customary ones: the paper does not name them.
FIRST_MOMENT, SECOND_MOMENT, TINY = 0.9, 0.999, 1e-8

RULE = optax.scale_by_adam(FIRST_MOMENT, SECOND_MOMENT, TINY)


class State(NamedTuple):
    """Everything that is carried from step to step.

    Attributes:
        params: the evaluation network.
        optimiser: Adam's state for it.
        latents: (M, 32), all BRDFs' codes, with Adam's moments `first` and `second` (M, 32) and
            the number of steps (M,) that have seen each: only those of a batch are updated.
    """

    params: Params
    optimiser: Any
    latents: jax.Array
    first: jax.Array
    second: jax.Array
    steps: jax.Array


def start(params: Params, brdfs: int) -> State:
    """The state before the first step: all codes are 1."""
    params = {name: jnp.asarray(v) for name, v in params.items() if name.startswith("evaluation.")}
    zeros = jnp.zeros((brdfs, LATENT))
    latents = jnp.full((brdfs, LATENT), FIRST_LATENT)
    return State(params, RULE.init(params), latents, zeros, zeros, jnp.zeros(brdfs, jnp.int32))


def l1_loss(params: Params, z: jax.Array, batch: Batch) -> jax.Array:
    """Mean |f_pred - f|; z: (B, 32)."""
    directions = direction_inputs(jnp.asarray(batch.wi), jnp.asarray(batch.wo))
    return jnp.mean(jnp.abs(evaluate(params, z[:, None], directions) - batch.f))


@jax.jit
def step(
    state: State, batch: Batch, weights_rate: float, latents_rate: float
) -> tuple[State, jax.Array]:
    """Update the weights and the batch's codes; returns the loss too."""
    z = state.latents[batch.rows]
    loss, (slope, z_slope) = jax.value_and_grad(l1_loss, (0, 1))(state.params, z, batch)
    update, optimiser = RULE.update(slope, state.optimiser)
    params = optax.apply_updates(
        state.params, jax.tree.map(lambda change: -weights_rate * change, update)
    )
    # The loss is a mean over the batch; Adam does not mind the factor.
    first = FIRST_MOMENT * state.first[batch.rows] + (1 - FIRST_MOMENT) * z_slope
    second = SECOND_MOMENT * state.second[batch.rows] + (1 - SECOND_MOMENT) * z_slope**2
    steps = state.steps[batch.rows] + 1
    bias = (1 - power[:, None] for power in (FIRST_MOMENT**steps, SECOND_MOMENT**steps))
    mean, square = (moment / b for moment, b in zip((first, second), bias, strict=True))
    z = z - latents_rate * mean / (jnp.sqrt(square) + TINY)
    return State(
        params,
        optimiser,
        state.latents.at[batch.rows].set(z),
        state.first.at[batch.rows].set(first),
        state.second.at[batch.rows].set(second),
        state.steps.at[batch.rows].set(steps),
    ), loss


def learn_epoch(
    state: State, batches: Any, weights_rate: float, latents_rate: float
) -> tuple[State, float]:
    """Take the steps of one epoch; returns the mean loss too."""
    losses = []
    for batch in batches:
        state, loss = step(state, batch, weights_rate, latents_rate)
        losses.append(loss)
    return state, float(np.mean(jax.device_get(losses)))
