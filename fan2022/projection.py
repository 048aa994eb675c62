"""Projection by Adam on compressed values, the method of the paper's authors.

The loss is the mean absolute difference of x / (1 + |x|), where x is f times the light's cosine.
The compression limits the weight of highlights, and the cosine limits the weight of grazing light.
Adam (Kingma and Ba 2015) takes steps of about its rate in every number of the code.

Source: `compress.py` of the authors (github.com/sssssy/pytorch-mitsuba-NLB_Release). There, steps
take the pairs in overlapping windows of a random order; here, every step draws pairs of its own.
Their x / (1 + x) has a pole that negative outputs of the network can reach.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax
from tqdm import tqdm

from fan2022.architecture import FIRST_LATENT, LATENT, PaperArchitecture, parameters_of
from fan2022.inference import LIGHT_COSINE, evaluate
from urushi.nets.mlp import Params

#: The learning rate of the first steps, its factor after each fifth of all steps, and the number of
#: decays: the rate falls from 1e-3 to 1.5e-5.
RATE, DECAY, DECAYS = 1e-3, 0.003**0.24, 3

#: BRDFs that are projected together, and their pairs in one step, at most: bounds memory.
TOGETHER, ROWS = 16, 1 << 13


def compressed(x: Any) -> Any:
    """x / (1 + |x|)."""
    return x / (1 + abs(x))


#: Its default constants.
ADAM = optax.scale_by_adam()


def rate(taken: int, steps: int) -> float:
    """The learning rate after `taken` of `steps` steps."""
    return RATE * DECAY ** min(5 * taken // steps, DECAYS)


def losses(params: Params, z: Any, directions: Any, f: Any) -> tuple[Any, Any]:
    """Sum of the compressed losses of codes z (M, 32), and mean absolute errors (M,) [1/sr].

    directions (M or 1, P, 6): `direction_inputs`; f (M, P) [1/sr].
    """
    value, cosine = evaluate(params, z[:, None], directions), directions[..., LIGHT_COSINE]
    difference = compressed(value * cosine) - compressed(f * cosine)
    return jnp.sum(jnp.mean(jnp.abs(difference), -1)), jnp.mean(jnp.abs(value - f), -1)


def draws(options: PaperArchitecture, count: int, seed: int = 0) -> np.ndarray | None:
    """Indices (steps, pairs) of every step's pairs out of `count`; None: all pairs in each step.

    They are drawn uniformly with replacement, the same for all BRDFs: a code does not depend on
    the BRDFs that are projected with it.
    """
    if options.pairs >= count:
        return None
    rng = np.random.default_rng(seed)
    return rng.integers(0, count, (options.steps, options.pairs), dtype=np.int32)


def project(
    params: Params, directions: np.ndarray, f: np.ndarray, options: PaperArchitecture, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes (M, 32) and mean absolute errors (M,) [1/sr] of BRDFs f (M, P).

    directions (M or 1, P, 6); seed: of the pairs of every step.
    """
    params = jax.tree.map(jnp.asarray, parameters_of(params, "evaluation"))
    most = max(1, min(TOGETHER, ROWS // min(options.pairs, f.shape[1])))
    # Blocks have a few shapes, for the compiler.
    together = min(most, 1 << max(len(f) - 1, 0).bit_length())
    at = draws(options, f.shape[1], seed)
    codes = np.empty((len(f), LATENT), np.float32)
    errors = np.empty(len(f), np.float32)
    starts = range(0, len(f), together)
    for start in tqdm(starts, desc="project", leave=False, delay=2, disable=None):
        block = slice(start, start + together)
        own = _padded(f[block], together)
        beside = directions if len(directions) == 1 else _padded(directions[block], together)
        z = jnp.full((together, LATENT), FIRST_LATENT, own.dtype)
        moments, error = ADAM.init(z), None
        for taken in range(options.steps):
            chosen = slice(None) if at is None else at[taken]
            update, moments, error = _direction(
                params, z, moments, beside[:, chosen], own[:, chosen]
            )
            z = z - rate(taken, options.steps) * update
        count = len(f[block])
        codes[block], errors[block] = (np.asarray(part)[:count] for part in (z, error))
    return codes, errors


def _padded(values: np.ndarray, count: int) -> np.ndarray:
    return np.pad(values, ((0, count - len(values)), *[(0, 0)] * (values.ndim - 1)), "edge")


@jax.jit
def _direction(params: Params, z: Any, moments: Any, directions: Any, f: Any) -> tuple:
    """Adam's direction for codes, its moments, and the errors of the codes."""
    slope, error = jax.grad(losses, 1, has_aux=True)(params, z, directions, f)
    return *ADAM.update(slope, moments), error
