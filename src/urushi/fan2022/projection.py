"""Projection by Adam on compressed values, the method of the paper's authors.

The loss is the mean absolute difference of x / (1 + x), where x is f times the light's cosine. The
compression limits the weight of highlights, and the cosine limits the weight of grazing light. Adam
(Kingma and Ba 2015) takes steps of about its rate in every number of the code. One definition runs
on NumPy and JAX.

Source: `compress.py` of the authors (github.com/sssssy/pytorch-mitsuba-NLB_Release). There, steps
take the pairs in overlapping windows of a random order; here, every step draws pairs of its own.
"""

from typing import Any, NamedTuple

import numpy as np

from urushi.fan2022.architecture import FIRST_LATENT, LATENT, AdamProjection
from urushi.fan2022.inference import LIGHT_COSINE, value_and_gradient
from urushi.nets.mlp import Params

#: The learning rate of the first steps, its factor after each fifth of all steps, and the number of
#: decays: the rate falls from 1e-3 to 1.5e-5.
RATE, DECAY, DECAYS = 1e-3, 0.003**0.24, 3

#: Adam's default constants.
FIRST_MOMENT, SECOND_MOMENT, TINY = 0.9, 0.999, 1e-8

#: Number of rows that NumPy evaluates together, so that activations stay in a core's cache.
ROWS = 512


class AdamState(NamedTuple):
    """State of the optimisation of M codes."""

    z: Any  # (M, 32)
    first: Any  # (M, 32) moments of the gradient
    second: Any
    steps: Any  # number of steps taken
    loss: Any  # (M,) compressed loss before the last step, in [0, 2)
    error: Any  # (M,) mean absolute error [1/sr] before the last step


def compressed(x: Any) -> Any:
    """x / (1 + |x|): the authors' x / (1 + x), continued to negative outputs of the network."""
    return x / (1 + abs(x))


def start(f: Any) -> AdamState:
    """The state before the first step: every code 1, as in training. f (M, P) [1/sr]."""
    xp = f.__array_namespace__()
    z = xp.full((f.shape[0], LATENT), FIRST_LATENT, dtype=f.dtype)
    nothing = xp.zeros(f.shape[:1], dtype=f.dtype)
    return AdamState(z, xp.zeros_like(z), xp.zeros_like(z), 0, nothing, nothing)


def rate(taken: Any, steps: int, xp: Any = np) -> Any:
    """The learning rate after `taken` of `steps` steps; xp: the array namespace."""
    return RATE * DECAY ** xp.minimum(5 * taken // steps, DECAYS)


def step(
    params: Params,
    state: AdamState,
    directions: Any,
    f: Any,
    steps: int,
    evaluate: Any = value_and_gradient,
) -> AdamState:
    """Take one of `steps` steps for every code.

    directions (M or 1, P, 6): `direction_inputs`; f (M, P) [1/sr], at the pairs of this step;
    evaluate: a function equal to `value_and_gradient`.
    """
    xp = f.__array_namespace__()
    value, jacobian = evaluate(params, state.z[:, None], directions)
    cos = directions[..., LIGHT_COSINE]
    x = value * cos
    difference = compressed(x) - compressed(f * cos)
    factor = xp.sign(difference) * cos / (1 + xp.abs(x)) ** 2
    slope = xp.mean(factor[..., None] * jacobian, axis=-2)
    first = FIRST_MOMENT * state.first + (1 - FIRST_MOMENT) * slope
    second = SECOND_MOMENT * state.second + (1 - SECOND_MOMENT) * slope * slope
    taken = state.steps + 1
    mean, square = first / (1 - FIRST_MOMENT**taken), second / (1 - SECOND_MOMENT**taken)
    size = xp.asarray(rate(state.steps, steps, xp), dtype=state.z.dtype)
    z = state.z - size * mean / (xp.sqrt(square) + TINY)
    loss = xp.mean(xp.abs(difference), axis=-1)
    return AdamState(z, first, second, taken, loss, xp.mean(xp.abs(value - f), axis=-1))


def draws(options: AdamProjection, count: int, seed: int = 0) -> np.ndarray | None:
    """Indices (steps, pairs) of every step's pairs out of `count`; None: all pairs in each step.

    They are drawn uniformly with replacement, the same for all BRDFs: a code does not depend on
    the BRDFs that are projected with it.
    """
    if options.pairs >= count:
        return None
    rng = np.random.default_rng(seed)
    return rng.integers(0, count, (options.steps, options.pairs), dtype=np.int32)


def project(
    params: Params, directions: np.ndarray, f: np.ndarray, options: AdamProjection, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes (M, 32) and mean absolute errors (M,) [1/sr] of BRDFs f (M, P).

    directions (M or 1, P, 6); seed: of the pairs of every step. Runs on NumPy.
    """
    at = draws(options, f.shape[1], seed)
    state = start(f)
    for index in range(options.steps):
        chosen = slice(None) if at is None else at[index]
        state = step(params, state, directions[:, chosen], f[:, chosen], options.steps, _in_parts)
    return state.z, state.error


def _in_parts(params: Params, z: np.ndarray, directions: np.ndarray) -> tuple[Any, Any]:
    """`value_and_gradient` by `ROWS` rows at a time."""
    count = max(1, ROWS // len(z))
    cuts = [slice(i, i + count) for i in range(0, directions.shape[1], count)]
    parts = [value_and_gradient(params, z, directions[:, cut]) for cut in cuts]
    value, gradient = (np.concatenate(arrays, axis=1) for arrays in zip(*parts, strict=True))
    return value, gradient
