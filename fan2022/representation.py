"""Joint training of the evaluation network and the latent codes of all training BRDFs.

Batches of the two-layer BRDFs are streamed from the store in bounded memory.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from fan2022.architecture import FIRST_LATENT, LATENT, parameters_of
from fan2022.inference import direction_inputs, evaluate
from fan2022.palette import read_shard
from fan2022.preset import PaperPreset
from urushi.nets.mlp import Params
from urushi.train.tables import TableStore

#: Maximum number of direction pairs in memory at once: half a gigabyte.
GROUP = 1 << 24


#: BRDFs that pass the network together, at most: so few activations stay in a core's cache.
TOGETHER = 8


#: step(state, batch, *rates) returns the next state and the loss of the batch.
Step = Callable[..., tuple[Any, jax.Array]]


class Batch(NamedTuple):
    """B different BRDFs at P pairs each."""

    rows: np.ndarray  # (B,) rows of the BRDFs in the store's part
    wi: np.ndarray  # (B, P, 3)
    wo: np.ndarray
    f: np.ndarray  # (B, P) [1/sr]


def epoch(store: TableStore, preset: PaperPreset, index: int) -> Iterator[Batch]:
    """The batches of one epoch, in an order that depends only on seed and epoch.

    Groups of BRDFs that fit into memory are visited in random order. Within a group the pairs of
    every BRDF are shuffled and cut into runs; a batch has one run from each of different BRDFs.
    BRDFs that do not fill a batch are left out of the run: batches of other sizes are slow where
    `TOGETHER` does not divide them.
    """
    rng, data = np.random.default_rng((preset.seed, index)), preset.data
    shards = rng.permutation(-(-preset.trained // data.shard))
    together = max(1, GROUP // (data.pairs * data.shard))
    for group in np.array_split(shards, -(-len(shards) // together)):
        rows, wi, wo, f = _trained(store, preset, group)
        count, pairs = f.shape
        run = min(preset.pairs, pairs)
        order = rng.permuted(np.tile(np.arange(pairs), (count, 1)), axis=1)
        for first in range(0, pairs - run + 1, run):
            # Batches without the rest; all in one where there are fewer.
            size = min(preset.stacks, count)
            for chosen in rng.permutation(count)[: count // size * size].reshape(-1, size):
                at = chosen[:, None], order[chosen, first : first + run]
                yield Batch(rows[chosen], wi[at], wo[at], f[at])


def _trained(store: TableStore, preset: PaperPreset, shards: np.ndarray) -> Batch:
    """All pairs of the BRDFs of some shards of the two-layer part that are trained on."""
    places = [
        (k, rows) for k, (name, rows) in enumerate(preset.data.places()) if name == "two-layer"
    ]
    parts = []
    for number in shards:
        shard, rows = places[number]
        index = np.arange(rows.start, rows.stop, dtype=np.int32)
        kept = index < preset.trained
        parts.append([values[kept] for values in (index, *read_shard(store, shard))])
    return Batch(*map(np.concatenate, zip(*parts, strict=True)))


#: Adam (Kingma and Ba 2015) with its default constants; the paper does not state its own.
RULE = optax.scale_by_adam()


class RepresentationState(NamedTuple):
    """The state that is carried from step to step."""

    params: Params  # the evaluation network
    optimiser: Any  # Adam's state for it
    latents: jax.Array  # (M, 32) codes of all BRDFs; a step updates the codes of its batch
    moments: optax.ScaleByAdamState  # of the codes, (M, 32), and their numbers of updates (M, 1)


def updated(params: Params, optimiser: Any, slope: Params, rate: Any) -> tuple[Params, Any]:
    """Parameters and Adam's state after a step along a gradient."""
    update, optimiser = RULE.update(slope, optimiser)
    changes = jax.tree.map(lambda change: -rate * change, update)
    return optax.apply_updates(params, changes), optimiser


def start(params: Params, brdfs: int) -> RepresentationState:
    """The state before the first step: all codes are 1."""
    params = jax.tree.map(jnp.asarray, parameters_of(params, "evaluation"))
    latents = jnp.full((brdfs, LATENT), FIRST_LATENT)
    moments = RULE.init(latents)._replace(count=jnp.zeros((brdfs, 1), jnp.int32))
    return RepresentationState(params, RULE.init(params), latents, moments)


def l1_loss(params: Params, z: jax.Array, batch: Batch) -> jax.Array:
    """Mean |f_pred - f|; z: (B, 32)."""
    directions = direction_inputs(jnp.asarray(batch.wi), jnp.asarray(batch.wo))
    return jnp.mean(jnp.abs(evaluate(params, z[:, None], directions) - batch.f))


def _loss_and_slopes(params: Params, z: jax.Array, batch: Batch) -> tuple[Any, Any, Any]:
    """`l1_loss` of a batch and its gradients by params and z, from slices of equal size."""
    brdfs = len(z)
    count = next(n for n in range(-(-brdfs // TOGETHER), brdfs + 1) if brdfs % n == 0)
    columns = z, *map(jnp.asarray, batch)
    slices = tuple(column.reshape(count, -1, *column.shape[1:]) for column in columns)

    def add(total: Any, part: Any) -> tuple[Any, Any]:
        z, *own = part
        loss, (slope, z_slope) = jax.value_and_grad(l1_loss, (0, 1))(params, z, Batch(*own))
        return jax.tree.map(jnp.add, total, (loss, slope)), z_slope

    start = jnp.float32(0), jax.tree.map(jnp.zeros_like, params)
    total, z_slope = jax.lax.scan(add, start, slices)
    loss, slope = jax.tree.map(lambda x: x / count, total)
    return loss, slope, z_slope.reshape(z.shape) / count


@jax.jit
def step(
    state: RepresentationState, batch: Batch, weights_rate: float, latents_rate: float
) -> tuple[RepresentationState, jax.Array]:
    """Update the weights and the batch's codes; returns the loss too."""
    z = state.latents[batch.rows]
    loss, slope, z_slope = _loss_and_slopes(state.params, z, batch)
    params, optimiser = updated(state.params, state.optimiser, slope, weights_rate)
    # The loss is a mean over the batch; Adam's step does not depend on that factor.
    of_batch = jax.tree.map(lambda moment: moment[batch.rows], state.moments)
    update, of_batch = RULE.update(z_slope, of_batch)
    z = z - latents_rate * update
    latents, moments = jax.tree.map(
        lambda all_codes, new: all_codes.at[batch.rows].set(new),
        (state.latents, state.moments),
        (z, of_batch),
    )
    return RepresentationState(params, optimiser, latents, moments), loss


def learnt(step: Step, state: Any, batches: Iterable[Any], *rates: float) -> tuple[Any, float]:
    """Take a step with each batch; returns the mean loss too."""
    losses = []
    for batch in batches:
        state, loss = step(state, batch, *rates)
        losses.append(loss)
    return state, float(np.mean(jax.device_get(losses)))
