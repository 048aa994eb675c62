"""Batches of training examples: pure functions of seed and step.

A training that was interrupted continues to the same bits.
"""

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.train.examples import Depth


class Batch(NamedTuple):
    """Stacks of all depths, deepest first, so that each coat belongs to the first stacks."""

    lobes: np.ndarray  # (B, L) the bottoms' lobes, see `nets.lobe`
    probes: np.ndarray  # (B, probes) the bottoms' values [1/sr] at the probe pairs, less the lobes
    # Columns `checks.COAT_COLUMNS` (B_k, C) of each coat, the lowest first. The B_k stacks that
    # have this coat are the first ones of the batch.
    coats: tuple[np.ndarray, ...]
    features: np.ndarray  # (B, P, D) of the direction pairs
    top: np.ndarray  # (B, P) the part of f [1/sr] that the stacks' own lobes reflect
    f: np.ndarray  # (B, P) simulated values [1/sr]


#: The items `start` to `start + count` of a sequence, as indices (count,).
Order = Callable[[int, int], np.ndarray]


def shuffled(size: int, seed: int, key: int = 0) -> Order:
    """An endless sequence of `size` items: every epoch has each of them once, shuffled anew.

    key: distinguishes sequences of the same seed.
    """

    @functools.lru_cache(1)
    def order(epoch: int) -> np.ndarray:
        seeds = np.random.SeedSequence(seed, spawn_key=(key, epoch, 0))
        return np.random.default_rng(seeds).permutation(size)

    def items(start: int, count: int) -> np.ndarray:
        found = [np.empty(0, np.int64)]
        while count:
            epoch, first = divmod(start, size)
            found.append(order(epoch)[first : first + count])
            start, count = start + len(found[-1]), count - len(found[-1])
        return np.concatenate(found)

    return items


def batches(depths: list[Depth], stacks: tuple[int, ...], seed: int) -> Callable[[int, int], Batch]:
    """The function of `stage.Task.batches`: every depth's items in shuffled epochs.

    depths: the examples by number of coats. stacks: of each depth in a step.
    """
    if len(stacks) != len(depths):
        raise ParameterError(
            f"the data holds stacks of up to {len(depths) - 1} coats, but the preset draws "
            f"stacks of up to {len(stacks) - 1}; give one number for each depth"
        )
    orders = [shuffled(depth.items, seed, coats) for coats, depth in enumerate(depths)]

    def rows(coats: int, items: np.ndarray) -> dict[str, np.ndarray]:
        held = depths[coats].examples()
        of_stacks = {name: getattr(held, name) for name in ("lobes", "probes", "coats")}
        of_items = {name: getattr(held, name)[items] for name in ("features", "top", "f")}
        return {name: x[held.stack[items]] for name, x in of_stacks.items()} | of_items

    return lambda step, steps: Batch(**taken(orders, rows, stacks, step, steps))


def taken(
    orders: Sequence[Order],
    rows: Callable[[int, np.ndarray], Mapping[str, np.ndarray]],
    counts: Sequence[int],
    step: int,
    steps: int,
) -> dict[str, Any]:
    """Columns of the batches of `steps` steps from `step` on, stacked along a first axis.

    rows: from the place of a depth and some of its items to columns by name; "coats" are
    (count, N, C), top to bottom, with one more coat at each depth. counts: items of each depth in a
    step. Columns join all depths, deepest first; "coats" become a tuple, see `Batch`.
    """
    parts = []
    for depth in reversed(range(len(orders))):
        count = counts[depth]
        columns = rows(depth, orders[depth](step * count, steps * count))
        parts.append({k: x.reshape(steps, count, *x.shape[1:]) for k, x in columns.items()})
    coats = [part.pop("coats") for part in parts]
    joined: dict[str, Any] = {
        name: np.concatenate([part[name] for part in parts], axis=1) for name in parts[0]
    }
    joined["coats"] = tuple(
        np.concatenate([x[:, :, -1 - k] for x in coats if x.shape[2] > k], axis=1)
        for k in range(coats[0].shape[2])
    )
    return joined
