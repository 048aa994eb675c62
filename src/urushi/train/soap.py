"""SOAP: Adam in the eigenbasis of Shampoo's preconditioner (Vyas et al. 2024, algorithm 3)."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax

#: Decay of the mean gradient, and decay of squares and preconditioner.
MEAN, SQUARES = 0.95, 0.99

#: Steps between two updates of the eigenbases: a decomposition costs more than a step.
EVERY = 20

#: Gradients below this share of the largest are rounding errors: their steps are reduced.
_ROUNDING = 1e-5
_TINY = 1e-30


class Side(NamedTuple):
    """Mean of G Gᵀ, or of Gᵀ G, of gradients G, and its eigenvectors as columns."""

    outer: jax.Array
    basis: jax.Array


class Matrix(NamedTuple):
    """Moments of one matrix (rows, columns)."""

    mean: jax.Array
    squares: jax.Array  # in the eigenbases
    left: Side
    right: Side


class SoapState(NamedTuple):
    """The number of steps, and the moments of all matrices as a tree like the parameters."""

    step: jax.Array
    matrices: Any


def soap(rate: optax.Schedule) -> optax.GradientTransformation:
    """The update rule for trees of matrices; `rate` is the learning rate by step."""

    def init(params: Any) -> SoapState:
        return SoapState(jnp.zeros((), jnp.int32), jax.tree.map(_beginning, params))

    def update(gradients: Any, state: SoapState, params: Any = None) -> tuple[Any, SoapState]:
        del params
        step = state.step + 1
        moved = jax.tree.map(lambda g, kept: _moved(g, kept, step), gradients, state.matrices)
        factor = -rate(state.step)
        updates = jax.tree.map(lambda _, pair: factor * pair[0], gradients, moved)
        return updates, SoapState(step, jax.tree.map(lambda _, pair: pair[1], gradients, moved))

    return optax.GradientTransformation(init, update)


def _beginning(x: jax.Array) -> Matrix:
    left, right = (Side(jnp.zeros((n, n), x.dtype), jnp.eye(n, dtype=x.dtype)) for n in x.shape)
    return Matrix(jnp.zeros_like(x), jnp.zeros_like(x), left, right)


def _moved(gradient: jax.Array, kept: Matrix, step: jax.Array) -> tuple[jax.Array, Matrix]:
    """The direction of a step, before the learning rate, and the updated moments."""
    left = _followed(kept.left, gradient @ gradient.T, step)
    right = _followed(kept.right, gradient.T @ gradient, step)
    rotated = left.basis.T @ gradient @ right.basis
    mean = MEAN * kept.mean + (1 - MEAN) * gradient
    squares = SQUARES * kept.squares + (1 - SQUARES) * rotated * rotated
    size = jnp.sqrt(squares / (1 - SQUARES**step))
    size = size + _ROUNDING * jnp.max(size) + _TINY
    direction = (left.basis.T @ mean @ right.basis) / (1 - MEAN**step) / size
    return left.basis @ direction @ right.basis.T, Matrix(mean, squares, left, right)


def _followed(side: Side, outer: jax.Array, step: jax.Array) -> Side:
    """A side with one more outer product; a power iteration updates its basis from time to time."""
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
