"""Projection of a part of the data into the latent space of the trained evaluation network."""

import jax
import numpy as np
from tqdm import tqdm

from urushi.data.store import Store
from urushi.nets.mlp import Params
from urushi.paper import projection
from urushi.paper.inference import direction_inputs
from urushi.paper.networks import PAIRS

#: BRDFs that are projected together.
TOGETHER = 16


def project_part(
    params: Params, store: Store, part: int, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes (S, 32) of a part's BRDFs and their mean absolute errors (S,).

    Each BRDF is evaluated at `PAIRS` of its own stratified pairs, chosen by `spread`.
    """
    described = store.spec.parts[part]
    rng = np.random.default_rng((seed, part))
    codes, losses = [], []
    with tqdm(total=described.stacks, desc=f"project {described.name}", disable=None) as progress:
        for shard in range(store.spec.shard_count(described)):
            arrays = store.read_shard(part, shard, ("wi", "wo", "f"))
            for start in range(0, len(arrays["f"]), TOGETHER):
                block = {name: values[start : start + TOGETHER] for name, values in arrays.items()}
                z, loss = _project_block(params, block, rng)
                codes.append(z)
                losses.append(loss)
                progress.update(len(z))
    return np.concatenate(codes), np.concatenate(losses)


def _project_block(
    params: Params, arrays: dict[str, np.ndarray], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Codes and errors of at most `TOGETHER` BRDFs."""
    at = spread(arrays["wi"], arrays["wo"], rng)
    wi, wo = (np.take_along_axis(arrays[name], at[..., None], 1) for name in ("wi", "wo"))
    f = np.take_along_axis(arrays["f"], at, 1)
    missing = TOGETHER - len(f)  # all blocks have one shape, for the compiler
    wi, wo, f = (np.concatenate([a, np.repeat(a[:1], missing, 0)]) for a in (wi, wo, f))
    z, loss = _project(params, direction_inputs(wi, wo), f)
    return np.asarray(z)[: len(at)], np.asarray(loss)[: len(at)]


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
