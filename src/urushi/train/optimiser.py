"""The optimisers of all stages: warm-up, half a cosine, clipping and averaged weights.

The precision of the large matrix products in training.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
import optax.contrib

from urushi.nets.mlp import Params
from urushi.train.devices import Devices
from urushi.train.presets import Schedule
from urushi.train.soap import MEAN, SQUARES, soap

#: Muon's iterations, each a polynomial a x + b x^3 + c x^5 of the singular values: they bring
#: everything in [0.005, 1] to within a twelfth of 1, each the best for where the one before has
#: led (Amsel et al. 2025). Four do what five of Jordan's do, and they are half of a step's cost.
ITERATIONS = (
    (8.2987, -24.4305, 18.0903),
    (3.9152, -2.9211, 0.5592),
    (3.1746, -2.3804, 0.4978),
    (2.1895, -1.5672, 0.4079),
)

#: A pytree of arrays, here always a flat dict of parameters.
Tree = Any


class TrainState(NamedTuple):
    """Everything that a stage carries from step to step."""

    params: Tree  # the trained ones
    average: Tree  # their exponential moving average
    optimiser: Tree


Loss = Callable[[Tree, Any], tuple[jax.Array, dict[str, jax.Array]]]
Steps = Callable[[TrainState, Any], tuple[TrainState, dict[str, jax.Array]]]


def optimiser(schedule: Schedule) -> optax.GradientTransformation:
    """The schedule's rule for the weight matrices, Adam (Kingma & Ba 2015) for the biases.

    "muon" (Jordan et al. 2024) makes each matrix's step orthogonal. That costs up to as much as the
    gradient, and it reaches the same error in less than half of Adam's steps. "soap" knows the
    curvature's main directions: close to a minimum it goes on where Muon's steps, as long whatever
    the gradient, only lift the error.
    """
    rate = optax.warmup_cosine_decay_schedule(
        0.0, schedule.learning_rate, schedule.warmup, schedule.steps
    )
    if schedule.rule == "muon":
        rule = optax.contrib.muon(rate, ITERATIONS, len(ITERATIONS), adam_b2=0.99)
    else:
        adam = optax.adam(rate, b1=MEAN, b2=SQUARES)
        rule = optax.partition(
            {2: soap(rate), 1: adam}, lambda params: jax.tree.map(jnp.ndim, params)
        )
    return optax.chain(optax.clip_by_global_norm(schedule.clip), rule)


def start(params: Tree, schedule: Schedule) -> TrainState:
    """The state before the first step."""
    params = {name: jnp.asarray(value) for name, value in params.items()}
    return TrainState(params, {**params}, optimiser(schedule).init(params))


def compile_steps(loss: Loss, schedule: Schedule, devices: Devices | None = None) -> Steps:
    """A function that takes several steps in one compiled loop.

    Args:
        loss: (params, batch) to (loss, terms to log).
        schedule: see `presets.Schedule`.
        devices: those that share the batches; by default JAX's default device alone.

    Returns:
        A function of a state and of batches stacked along a first axis; it returns the new state
        and the terms' means. One call for many steps, because handing over a small step costs
        about as much as computing it.
    """
    rule = optimiser(schedule)

    def evaluated(params: Tree, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        return loss(lowered(params, schedule.precision), batch)

    def step(state: TrainState, batch: Any) -> tuple[TrainState, dict[str, jax.Array]]:
        (_, terms), gradient = jax.value_and_grad(evaluated, has_aux=True)(state.params, batch)
        update, inner = rule.update(gradient, state.optimiser, state.params)
        params = optax.apply_updates(state.params, update)
        average = jax.tree.map(
            lambda mean, new: mean + (1 - schedule.average) * (new - mean), state.average, params
        )
        return TrainState(params, average, inner), terms

    def steps(state: TrainState, batches: Any) -> tuple[TrainState, dict[str, jax.Array]]:
        state, terms = jax.lax.scan(step, state, batches)
        return state, jax.tree.map(jnp.mean, terms)

    if devices is None:
        return jax.jit(steps)
    compiled = jax.jit(steps, out_shardings=devices.replicated())
    return lambda state, batches: compiled(*devices.place(state, batches))


def lowered(params: Params, precision: str) -> dict[str, Any]:
    """Parameters with which a loss is evaluated: as they are, or hidden matrices in bfloat16.

    Their products are then of bfloat16 factors. The first and the last layer of every network stay
    in float32, for a feature or an output with 8 bits would be wrong by half a per cent; so do all
    biases, activations, and the parameters that the optimiser keeps.
    """
    if precision == "float32":
        return dict(params)
    layers = [name.split(".") for name in params if name.endswith(".weight")]
    last = {net: max(int(k) for other, k, _ in layers if other == net) for net, _, _ in layers}
    hidden = {f"{net}.{k}.weight" for net, k, _ in layers if 0 < int(k) < last[net]}
    return {
        name: value.astype(jnp.bfloat16) if name in hidden else value
        for name, value in params.items()
    }
