"""Batches of training examples: pure functions of seed and step.

A training that was interrupted continues to the same bits.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.train.examples import Depth


class Batch(NamedTuple):
    """Stacks of all depths, deepest first, so that each coat belongs to the first stacks.

    Attributes:
        lobes: (B, L) the bottoms' lobes, see `nets.lobe`.
        probes: (B, probes) the bottoms' values [1/sr] at the probe pairs, without their lobes.
        coats: (B_k, C) columns `checks.COAT_COLUMNS` of each coat, the lowest first, for the B_k
            stacks that have this coat, which are the first ones of the batch.
        features: (B, P, D) of the direction pairs.
        top: (B, P) the part of f [1/sr] that the stacks' own lobes reflect.
        f: (B, P) simulated values [1/sr].
    """

    lobes: np.ndarray
    probes: np.ndarray
    coats: tuple[np.ndarray, ...]
    features: np.ndarray
    top: np.ndarray
    f: np.ndarray


class Order:
    """An endless sequence of items: every epoch has each of them once, shuffled anew.

    Args:
        size: number of items.
        seed: seed of all shuffling.
        key: distinguishes sequences of the same seed.
    """

    def __init__(self, size: int, seed: int, key: int = 0) -> None:
        self.size = size
        self._seed, self._key = seed, key
        self._shuffled: tuple[int, np.ndarray] = -1, np.empty(0, np.int64)

    def items(self, start: int, count: int) -> np.ndarray:
        """The items `start` to `start + count` of the sequence, as indices (count,)."""
        found = [np.empty(0, np.int64)]
        while count:
            epoch, first = divmod(start, self.size)
            found.append(self._epoch(epoch)[first : first + count])
            start, count = start + len(found[-1]), count - len(found[-1])
        return np.concatenate(found)

    def _epoch(self, epoch: int) -> np.ndarray:
        """The order of one epoch; that of the last one asked for is kept."""
        if self._shuffled[0] != epoch:
            seeds = np.random.SeedSequence(self._seed, spawn_key=(self._key, epoch, 0))
            self._shuffled = epoch, np.random.default_rng(seeds).permutation(self.size)
        return self._shuffled[1]


def batches(depths: list[Depth], stacks: tuple[int, ...], seed: int) -> Callable[[int, int], Batch]:
    """The function of `stage.Lesson.batches`: every depth's items in shuffled epochs.

    Args:
        depths: the examples by number of coats.
        stacks: number of stacks of each depth in a step.
        seed: seed of the shuffling.
    """
    if len(stacks) != len(depths):
        raise ParameterError(
            f"the data holds stacks of up to {len(depths) - 1} coats, but the preset draws "
            f"stacks of up to {len(stacks) - 1}; give one number for each depth"
        )
    orders = [Order(depth.items, seed, coats) for coats, depth in enumerate(depths)]

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
    step. Columns are those of all depths, deepest first; "coats" become a tuple, see `Batch`.
    """
    parts = []
    for depth in reversed(range(len(orders))):
        count = counts[depth]
        columns = rows(depth, orders[depth].items(step * count, steps * count))
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
