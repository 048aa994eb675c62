"""The damped least-squares solver of all fits (Marquardt 1963), for one problem or for many."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class FitState(NamedTuple):
    """The state of fits of U numbers at a point that determines the numbers."""

    x: np.ndarray  # (..., L) the point
    objective: Any  # (...) is minimised
    slope: np.ndarray  # (..., U) half the gradient of the objective
    curvature: np.ndarray  # (..., U, U) half its Hessian, by Gauss and Newton


class Damping(NamedTuple):
    """Damping relative to the mean of the curvature's diagonal."""

    first: float  # at the first step
    decrease: float  # factor after a step that lowers the objective
    increase: float  # factor after any other step


def damped_steps(
    state_at: Callable[[np.ndarray], FitState],
    x: np.ndarray,
    steps: int,
    damping: Damping,
    moved: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return x (..., L) whose objective is at most that of the given x, for each problem.

    Every step is damped, and accepted only if it lowers the objective.

    Args:
        state_at: gives the state at x.
        x: (..., L) the initial guesses.
        steps: number of trial steps.
        damping: its first value and its change.
        moved: gives x (..., L) after a step (..., U), which is subtracted.
    """
    state = state_at(x)
    factor = np.full(np.shape(state.objective), damping.first)
    for _ in range(steps):
        size = state.curvature.shape[-1]
        mean = np.trace(state.curvature, axis1=-2, axis2=-1) / size
        added = np.asarray(factor * mean + 1e-12)[..., None, None]
        damped = state.curvature + added * np.eye(size, dtype=state.curvature.dtype)
        step = np.linalg.solve(damped, state.slope[..., None])[..., 0]
        new = state_at(moved(state.x, step))
        better = np.asarray(new.objective < state.objective)  # false for NaN
        state = FitState(*(_chosen(better, *pair) for pair in zip(new, state, strict=True)))
        factor = factor * np.where(better, damping.decrease, damping.increase)
    return state.x


def _chosen(better: np.ndarray, new: Any, old: Any) -> np.ndarray:
    """New values (..., K) of the problems (...) that are better, old ones of the others."""
    return np.where(better.reshape(better.shape + (1,) * (np.ndim(new) - better.ndim)), new, old)
