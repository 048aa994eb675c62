"""Batches of the two-layer BRDFs, streamed from the store in bounded memory."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from urushi.data.store import Store
from urushi.train.paper.preset import PaperPreset

#: Direction pairs in memory together, at most: half a gigabyte.
GROUP = 1 << 24


class Batch(NamedTuple):
    """B different BRDFs at P pairs each.

    Attributes:
        rows: (B,) which BRDFs; wi, wo: (B, P, 3); f: (B, P) [1/sr].
    """

    rows: np.ndarray
    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray


def epoch(store: Store, preset: PaperPreset, index: int) -> Iterator[Batch]:
    """The batches of one epoch, in an order that depends on seed and epoch alone.

    Groups of BRDFs that fit into memory come in random order. Within a group the pairs of every
    BRDF are shuffled and cut into runs; a batch has one run each of different BRDFs.
    """
    rng = np.random.default_rng((preset.seed, index))
    for shards in shuffled_groups(preset, rng):
        rows, arrays = _trained(store, preset, shards)
        count, pairs = arrays["f"].shape
        run = min(preset.pairs, pairs)
        order = rng.permuted(np.tile(np.arange(pairs), (count, 1)), axis=1)
        for first in range(0, pairs - run + 1, run):
            stacks = rng.permutation(count)
            for chosen in np.array_split(stacks, -(-count // preset.stacks)):
                at = chosen[:, None], order[chosen, first : first + run]
                yield Batch(rows[chosen], arrays["wi"][at], arrays["wo"][at], arrays["f"][at])


def shuffled_groups(preset: PaperPreset, rng: np.random.Generator) -> list[np.ndarray]:
    """Shards with BRDFs to train on, in random order, in groups that fit into memory."""
    part, shard = preset.part("two-layer"), preset.data.shard
    shards = rng.permutation(-(-trained(preset) // shard))
    together = max(1, GROUP // (part.pairs * shard))
    return np.array_split(shards, -(-len(shards) // together))


def trained(preset: PaperPreset) -> int:
    """Number of two-layer BRDFs that are trained on, the first ones."""
    return preset.part("two-layer").stacks - preset.validation


def _trained(
    store: Store, preset: PaperPreset, shards: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Rows (R,) int32 and arrays of some shards' BRDFs, without those for validation."""
    part = [described.name for described in preset.data.parts].index("two-layer")
    slices = [preset.data.rows(part, shard) for shard in shards]
    rows = np.concatenate([np.arange(s.start, s.stop, dtype=np.int32) for s in slices])
    kept = rows < trained(preset)
    read = [store.read_shard(part, int(shard), ("wi", "wo", "f")) for shard in shards]
    arrays = {name: np.concatenate([a[name] for a in read])[kept] for name in ("wi", "wo", "f")}
    return rows[kept], arrays
