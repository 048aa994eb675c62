"""Orders of training examples: pure functions of seed and step.

A training that was interrupted continues to the same bits.
"""

import functools
from collections.abc import Callable

import numpy as np

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
