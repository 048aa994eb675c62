"""The order of examples: a pure function of seed, epoch and position."""

import numpy as np


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
