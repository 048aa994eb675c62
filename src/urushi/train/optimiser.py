"""The optimiser of the layering network: schedule, update rule and averaged weights."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax

from urushi.errors import ParameterError

#: A pytree of arrays.
Tree = Any


@dataclass(frozen=True)
class Schedule:
    """Length and learning rate of a training."""

    steps: int  # optimiser steps; the learning rate falls to zero at the last one (half a cosine)
    warmup: int  # steps in which the learning rate rises from zero
    learning_rate: float  # its peak
    clip: float = 1.0  # largest norm of the gradient
    average: float = 0.999  # decay per step of the moving average of the weights, the result
    steps_per_call: int = 16  # steps that run in one call of the compiled loop
    checkpoint_every: int = 2048  # steps between two checkpoints, a multiple of `steps_per_call`

    def __post_init__(self) -> None:
        for name in ("steps", "checkpoint_every"):
            if getattr(self, name) % self.steps_per_call:
                raise ParameterError(
                    f"the schedule's {name} is {getattr(self, name)}; "
                    f"it must be a multiple of its {self.steps_per_call} steps_per_call"
                )


class TrainState(NamedTuple):
    """The state of a training between two steps."""

    params: Tree  # the parameters that learn
    average: Tree  # their exponential moving average
    optimiser: Tree  # the state of the update rule


def optimiser(schedule: Schedule) -> optax.GradientTransformation:
    """SOAP for the weight matrices, Adam (Kingma and Ba 2015) for the biases.

    The learning rate rises linearly, then falls by half a cosine; gradients are clipped. SOAP steps
    along the main directions of the curvature, and lowers the error also close to a minimum.
    """
    rate = optax.warmup_cosine_decay_schedule(
        0.0, schedule.learning_rate, schedule.warmup, schedule.steps
    )
    rules = {2: soap(rate), 1: optax.adam(rate, b1=MEAN, b2=SQUARES)}
    rule = optax.partition(rules, lambda params: jax.tree.map(jnp.ndim, params))
    return optax.chain(optax.clip_by_global_norm(schedule.clip), rule)


def start(params: Tree, schedule: Schedule) -> TrainState:
    """The state before the first step."""
    params = {name: jnp.asarray(value) for name, value in params.items()}
    return TrainState(params, {**params}, optimiser(schedule).init(params))


def compile_steps(
    loss: Callable[[Tree, Any], jax.Array], schedule: Schedule
) -> Callable[[TrainState, Any], tuple[TrainState, jax.Array]]:
    """Compile a function from a state and batches to the new state and the mean loss.

    Batches are stacked along a first axis. One call takes many steps, because the overhead of a
    call is about the cost of a small step.

    loss: of the parameters and a batch.
    """
    rule = optimiser(schedule)

    def step(state: TrainState, batch: Any) -> tuple[TrainState, jax.Array]:
        value, gradient = jax.value_and_grad(loss)(state.params, batch)
        update, inner = rule.update(gradient, state.optimiser, state.params)
        params = optax.apply_updates(state.params, update)
        average = jax.tree.map(
            lambda mean, new: mean + (1 - schedule.average) * (new - mean), state.average, params
        )
        return TrainState(params, average, inner), value

    @jax.jit
    def steps(state: TrainState, batches: Any) -> tuple[TrainState, jax.Array]:
        state, losses = jax.lax.scan(step, state, batches)
        return state, jnp.mean(losses)

    return steps


#: SOAP's decay rates per step: of the mean gradient M; of the squares V and of L and R.
MEAN, SQUARES = 0.95, 0.99

#: SOAP: steps between two updates of the eigenbases; a decomposition costs more than a step.
EVERY = 20

#: Gradients below this share of the largest are rounding errors: their steps are reduced.
_ROUNDING = 1e-5
_TINY = 1e-30


class Side(NamedTuple):
    """One side of Shampoo's preconditioner, (n, n) for a side of n rows or columns."""

    outer: jax.Array  # moving average over gradients G: of G Gᵀ on the left (L), Gᵀ G (R)
    basis: jax.Array  # eigenvectors of `outer` as columns


class Matrix(NamedTuple):
    """SOAP's moments of one weight matrix (rows, columns)."""

    mean: jax.Array  # M, the moving average of the gradient
    squares: jax.Array  # V, the moving average of the squared gradient in the eigenbases
    left: Side
    right: Side


class SoapState(NamedTuple):
    """SOAP's state."""

    step: jax.Array  # number of steps taken
    matrices: Any  # a `Matrix` for each parameter


def soap(rate: optax.Schedule) -> optax.GradientTransformation:
    """Adam in the eigenbasis of Shampoo's preconditioner (Vyas et al. 2024, algorithm 3).

    Every parameter is a matrix. Its gradient G is rotated into the eigenbases Q_L and Q_R of the
    averages L of G Gᵀ and R of Gᵀ G, where Adam divides by the root of the mean square. The step
    is rotated back. The eigenbases are updated every `EVERY` steps by one power iteration.
    """

    def init(params: Any) -> SoapState:
        def beginning(x: jax.Array) -> Matrix:
            sides = (Side(jnp.zeros((n, n), x.dtype), jnp.eye(n, dtype=x.dtype)) for n in x.shape)
            return Matrix(jnp.zeros_like(x), jnp.zeros_like(x), *sides)

        return SoapState(jnp.zeros((), jnp.int32), jax.tree.map(beginning, params))

    def update(gradients: Any, state: SoapState, _: Any = None) -> tuple[Any, SoapState]:
        step = state.step + 1
        moved = jax.tree.map(lambda g, kept: _moved(g, kept, step), gradients, state.matrices)
        factor = -rate(state.step)
        updates = jax.tree.map(lambda _, pair: factor * pair[0], gradients, moved)
        return updates, SoapState(step, jax.tree.map(lambda _, pair: pair[1], gradients, moved))

    return optax.GradientTransformation(init, update)


def _moved(gradient: jax.Array, kept: Matrix, step: jax.Array) -> tuple[jax.Array, Matrix]:
    """One step for one matrix: its direction, without the learning rate, and the new moments."""
    left = _followed(kept.left, gradient @ gradient.T, step)
    right = _followed(kept.right, gradient.T @ gradient, step)
    rotated = left.basis.T @ gradient @ right.basis  # Q_Lᵀ G Q_R
    mean = MEAN * kept.mean + (1 - MEAN) * gradient
    squares = SQUARES * kept.squares + (1 - SQUARES) * rotated * rotated
    size = jnp.sqrt(squares / (1 - SQUARES**step))
    size = size + _ROUNDING * jnp.max(size) + _TINY
    direction = (left.basis.T @ mean @ right.basis) / (1 - MEAN**step) / size
    return left.basis @ direction @ right.basis.T, Matrix(mean, squares, left, right)


def _followed(side: Side, outer: jax.Array, step: jax.Array) -> Side:
    """Add an outer product to a side; every `EVERY` steps, update its basis."""
    first = step == 1
    outer = jnp.where(first, outer, SQUARES * side.outer + (1 - SQUARES) * outer)
    basis = jax.lax.cond(
        step % EVERY == 1,
        lambda: jax.lax.cond(
            first,
            lambda: jnp.linalg.eigh(outer)[1][:, ::-1],
            lambda: jnp.linalg.qr(outer @ side.basis)[0],
        ),
        lambda: side.basis,
    )
    return Side(outer, basis)
