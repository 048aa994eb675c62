"""Projection of a part of the data into the latent space of the trained evaluation network."""

import functools

import jax
import numpy as np
from tqdm import tqdm

from urushi.fan2022 import adam, projection
from urushi.fan2022.architecture import AdamProjection
from urushi.fan2022.inference import direction_inputs
from urushi.fan2022.networks import PAIRS
from urushi.nets.mlp import Params
from urushi.train.data.store import Store

#: BRDFs that are projected together, at most.
TOGETHER = 16

#: Pairs of a projection by Adam in one step, of all BRDFs together, at most: bounds memory.
ADAM_ROWS = TOGETHER * PAIRS


def project_part(
    params: Params, store: Store, part: int, seed: int = 0, options: AdamProjection | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes (S, 32) of a part's BRDFs and their mean absolute errors (S,) [1/sr].

    options: of the projection by Adam, which draws from all of a BRDF's stratified pairs. None:
    Levenberg-Marquardt at `PAIRS` of them, chosen by `spread`.
    """
    described = store.spec.parts[part]
    together = TOGETHER
    if options is not None:
        together = max(1, min(TOGETHER, ADAM_ROWS // min(options.pairs, described.pairs)))
    rng = np.random.default_rng((seed, part))
    codes, errors = [], []
    with tqdm(total=described.stacks, desc=f"project {described.name}", disable=None) as progress:
        for shard in range(store.spec.shard_count(described)):
            arrays = store.read_shard(part, shard, ("wi", "wo", "f"))
            for start in range(0, len(arrays["f"]), together):
                block = {name: values[start : start + together] for name, values in arrays.items()}
                count = len(block["f"])
                if options is None:
                    block = _chosen(block, rng)
                directions, f = _padded(block, together)
                if options is None:
                    z, error = _project(params, directions, f)
                else:
                    at = adam.draws(options, f.shape[1], seed)
                    z, error = _project_by_adam(params, directions, f, at, options.steps)
                codes.append(np.asarray(z)[:count])
                errors.append(np.asarray(error)[:count])
                progress.update(count)
    return np.concatenate(codes), np.concatenate(errors)


def _chosen(arrays: dict[str, np.ndarray], rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The arrays at the pairs that `spread` chooses."""
    at = spread(arrays["wi"], arrays["wo"], rng)
    return {
        name: np.take_along_axis(values, at[..., None] if values.ndim == 3 else at, 1)
        for name, values in arrays.items()
    }


def _padded(arrays: dict[str, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Direction inputs and values of `count` BRDFs: all blocks have one shape, for the compiler."""
    missing = count - len(arrays["f"])
    wi, wo, f = (
        np.concatenate([a, np.repeat(a[:1], missing, 0)])
        for a in (arrays["wi"], arrays["wo"], arrays["f"])
    )
    return direction_inputs(wi, wo), f


def spread(wi: np.ndarray, wo: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Choose at most `PAIRS` pairs of every BRDF, as indices (B, P'), distributed like probe pairs.

    wi, wo: (B, P, 3). Two thirds are drawn with a density that is uniform in the logarithm of the
    half angle, because plain strata have few pairs near highlights; the others are drawn uniformly.
    """
    half = wi + wo
    tangent2 = (half[..., 0] ** 2 + half[..., 1] ** 2) / half[..., 2] ** 2
    count = min(PAIRS, wi.shape[1])
    # Draws without replacement: the largest of Gumbel variables shifted by the log densities
    # (Efraimidis and Spirakis 2006).
    gumbel = rng.gumbel(size=tangent2.shape)
    near_highlights = np.argsort(-(gumbel - np.log(tangent2 + 1e-6)), axis=1)[:, : 2 * count // 3]
    gumbel = rng.gumbel(size=tangent2.shape)
    np.put_along_axis(gumbel, near_highlights, -np.inf, axis=1)
    others = np.argsort(-gumbel, axis=1)[:, : count - near_highlights.shape[1]]
    return np.concatenate([near_highlights, others], axis=1)


@jax.jit
def _project(params: Params, directions: jax.Array, f: jax.Array) -> tuple[jax.Array, jax.Array]:
    def step(_: int, state: projection.ProjectionState) -> projection.ProjectionState:
        return projection.step(params, state, directions, f)

    state = projection.start(params, directions, f)
    state = jax.lax.fori_loop(0, projection.STEPS, step, state)
    return state.z, state.loss


@functools.partial(jax.jit, static_argnums=4)
def _project_by_adam(
    params: Params, directions: jax.Array, f: jax.Array, at: jax.Array | None, steps: int
) -> tuple[jax.Array, jax.Array]:
    def step(index: int, state: adam.AdamState) -> adam.AdamState:
        if at is None:
            return adam.step(params, state, directions, f, steps)
        return adam.step(params, state, directions[:, at[index]], f[:, at[index]], steps)

    state = jax.lax.fori_loop(0, steps, step, adam.start(f))
    return state.z, state.error
