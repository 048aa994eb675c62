"""Projection: the latent code whose decoded values are closest in L1, at fixed weights.

The paper optimises the latent code by back-propagation and does not name the optimiser. A code has
only 32 numbers and one backward pass gives the whole Jacobian, so this is Levenberg-Marquardt on
iteratively reweighted squares, whose sum is the L1 loss. Gradient descent needs some thousands of
passes where this needs 16. One definition runs on NumPy and JAX.
"""

from typing import Any, NamedTuple

import numpy as np

from urushi.fan2022.architecture import FIRST_LATENT, LATENT
from urushi.fan2022.inference import value_and_gradient
from urushi.nets.least_squares import damped_step
from urushi.nets.mlp import Params

#: Number of forward and backward passes of a projection.
STEPS = 16

#: Errors below this share of a BRDF's mean value weigh as if they were this large.
KNEE = 0.1

#: The first damping, relative to the mean curvature; its factors after good and bad steps; and its
#: least value. The least damping keeps codes near their start where the values hardly depend on
#: them. This costs no accuracy and makes the codes easier to predict for the layering network.
DAMPING, EASED, RAISED, LEAST = 1e-2, 0.25, 8.0, 1e-2


class ProjectionState(NamedTuple):
    """State of the optimisation of M codes at P pairs, with the best codes so far.

    Attributes:
        z: (M, 32); loss: (M,) mean absolute error; error: (M, P); jacobian: (M, P, 32);
        damping: (M,).
    """

    z: Any
    loss: Any
    error: Any
    jacobian: Any
    damping: Any


def start(params: Params, directions: Any, f: Any) -> ProjectionState:
    """The state before the first step: every code 1, as in training.

    directions (M or 1, P, 6): `direction_inputs`; f (M, P) [1/sr].
    """
    xp = f.__array_namespace__()
    z = xp.full((f.shape[0], LATENT), FIRST_LATENT, dtype=f.dtype)
    return _at(params, z, directions, f, xp.full(f.shape[:1], DAMPING, dtype=f.dtype))


def step(params: Params, state: ProjectionState, directions: Any, f: Any) -> ProjectionState:
    """Try one damped step for every code, and keep the steps that lower the loss."""
    xp = f.__array_namespace__()
    knee = KNEE * xp.mean(xp.abs(f), axis=-1, keepdims=True) + 1e-6
    weight = 1 / xp.maximum(xp.abs(state.error), knee)
    weighted = xp.matrix_transpose(state.jacobian * weight[..., None])
    curvature = weighted @ state.jacobian
    slope = (weighted @ state.error[..., None])[..., 0]
    trial = state.z - damped_step(curvature, slope, state.damping)
    new = _at(params, trial, directions, f, xp.maximum(state.damping * EASED, LEAST))
    old = state._replace(damping=state.damping * RAISED)
    better = new.loss < state.loss  # false for NaN
    return ProjectionState(
        *(
            xp.where(xp.reshape(better, (-1,) + (1,) * (a.ndim - 1)), a, b)
            for a, b in zip(new, old, strict=True)
        )
    )


def _at(params: Params, z: Any, directions: Any, f: Any, damping: Any) -> ProjectionState:
    xp = f.__array_namespace__()
    value, jacobian = value_and_gradient(params, z[:, None], directions)
    error = value - f
    return ProjectionState(z, xp.mean(xp.abs(error), axis=-1), error, jacobian, damping)


def project(
    params: Params, directions: np.ndarray, f: np.ndarray, steps: int = STEPS
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes (M, 32) and mean absolute errors (M,) of BRDFs f (M, P)."""
    state = start(params, directions, f)
    for _ in range(steps):
        state = step(params, state, directions, f)
    return state.z, state.loss
