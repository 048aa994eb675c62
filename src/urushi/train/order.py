"""The order of a depth's examples: a pure function of seed, epoch and position.

Items lie in shards. An epoch visits the shards in a random order, cut into windows that fit into
memory; the items of a window are shuffled. Data that fit into memory are one window, which is
shuffled as a whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

#: The shards of a window, in ascending order.
Window = tuple[int, ...]


@dataclass(frozen=True)
class Run:
    """Consecutive items of the endless sequence that lie in one window.

    Attributes:
        window: the shards to have in memory.
        following: the next window, which can be read in the background.
        items: (n,) indices into the concatenated items of the window's shards.
    """

    window: Window
    following: Window
    items: np.ndarray


class Order:
    """The endless sequence of one depth's items, epoch after epoch.

    Args:
        sizes: number of items of every shard, for every part.
        capacity: maximum number of items of a window; a larger shard is a window by itself.
        seed: seed of all shuffling.
        key: distinguishes sequences of the same seed.
    """

    def __init__(
        self, sizes: Sequence[Sequence[int]], capacity: int, seed: int, key: int = 0
    ) -> None:
        self._parts = [len(part) for part in sizes]
        self._sizes = np.array([size for part in sizes for size in part])
        self._capacity = capacity
        self._seed = seed, key
        self._epochs: dict[int, tuple[list[Window], np.ndarray]] = {}
        self._shuffled: tuple[tuple[int, int], np.ndarray] = ((-1, -1), np.empty(0, np.int64))

    @property
    def size(self) -> int:
        """Number of items of an epoch."""
        return int(self._sizes.sum())

    def windows(self, epoch: int) -> list[Window]:
        """The windows of an epoch, in the order in which they are visited."""
        return self._epoch(epoch)[0]

    def runs(self, start: int, count: int) -> list[Run]:
        """The runs that contain the items `start` to `start + count` of the sequence."""
        found = []
        while count:
            epoch, first = divmod(start, self.size)
            windows, ends = self._epoch(epoch)
            place = int(np.searchsorted(ends, first, side="right"))
            begin = int(ends[place - 1]) if place else 0
            order = self._items(epoch, place, int(ends[place]) - begin)
            items = order[first - begin : first - begin + count]
            last = place + 1 == len(windows)
            following = self.windows(epoch + 1)[0] if last else windows[place + 1]
            found.append(Run(windows[place], following, items))
            start, count = start + len(items), count - len(items)
        return found

    def _epoch(self, epoch: int) -> tuple[list[Window], np.ndarray]:
        """The windows of an epoch, and the number of items up to the end of each."""
        if epoch not in self._epochs:
            windows = self._cut(self._generator(epoch))
            lengths = [int(self._sizes[list(window)].sum()) for window in windows]
            adjacent = {k: v for k, v in self._epochs.items() if abs(k - epoch) == 1}
            self._epochs = {**adjacent, epoch: (windows, np.cumsum(lengths))}
        return self._epochs[epoch]

    def _cut(self, rng: np.random.Generator) -> list[Window]:
        """Shuffle the shards and cut them into windows.

        Each part's shards are spread evenly over the epoch, so that all windows are similar: the
        k-th of n lies at a random place between k / n and (k + 1) / n of it.
        """
        places = [(rng.permutation(n) + rng.random(n)) / n for n in self._parts]
        windows: list[Window] = []
        held: list[int] = []
        room = self._capacity
        for shard in np.argsort(np.concatenate(places)).tolist():
            size = int(self._sizes[shard])
            if held and size > room:
                windows.append(tuple(sorted(held)))
                held, room = [], self._capacity
            held.append(shard)
            room -= size
        return [*windows, tuple(sorted(held))]

    def _items(self, epoch: int, place: int, length: int) -> np.ndarray:
        if self._shuffled[0] != (epoch, place):
            order = self._generator(epoch, place).permutation(length)
            self._shuffled = (epoch, place), order
        return self._shuffled[1]

    def _generator(self, *place: int) -> np.random.Generator:
        seed, key = self._seed
        return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(key, *place)))
