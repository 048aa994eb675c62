"""The specification of a data store, which is in the store's manifest and in a preset."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.core import direction_sets
from urushi.errors import ParameterError
from urushi.train.distribution import Source, to_dict


@dataclass(frozen=True)
class Part:
    """Stacks of one distribution, with the direction pairs at which each is simulated.

    Attributes:
        name: the part's name in the store, unique there.
        distribution: the distribution of the stacks' parameters.
        stacks: number of stacks.
        pairs: number of direction pairs of a stack; every stack has its own.
        directions: name of the pairs' direction set, see `core.direction_sets`.
        walks: number of random walks of a pair; bottoms without a coat are analytic and need none.
    """

    name: str
    distribution: Source
    stacks: int
    pairs: int
    walks: int
    directions: str = "training"

    def __post_init__(self) -> None:
        for name in ("stacks", "pairs", "walks"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 1:
                raise ParameterError(
                    f"part '{self.name}' has {name} = {value!r}; give a positive integer"
                )
        direction_sets.check_set(self.directions, self.pairs, f"part '{self.name}'")


@dataclass(frozen=True)
class DataSpec:
    """The parts of a data store, its seed and how it is cut into shards.

    Attributes:
        parts: the parts, in the order of generation.
        seed: seed of parameters, directions and walks.
        shard: number of stacks that are drawn, simulated and written together.
    """

    parts: tuple[Part, ...]
    seed: int = 0
    shard: int = 256

    def __post_init__(self) -> None:
        if len({part.name for part in self.parts}) != len(self.parts):
            raise ParameterError("two parts of the data specification have the same name")

    def shards(self) -> Iterator[tuple[int, int]]:
        """Yield every (part index, shard index), in order."""
        for index, part in enumerate(self.parts):
            for shard in range(self.shard_count(part)):
                yield index, shard

    def shard_count(self, part: Part) -> int:
        """Number of shards of a part; the last one may be smaller than the others."""
        return -(-part.stacks // self.shard)

    def rows(self, part: int, shard: int) -> slice:
        """The rows of a part that belong to one of its shards."""
        start = shard * self.shard
        return slice(start, min(start + self.shard, self.parts[part].stacks))

    def seeds(self, part: int, shard: int) -> np.random.SeedSequence:
        """The seeds of one shard, independent of all others and of the order of generation."""
        return np.random.SeedSequence(self.seed, spawn_key=(part, shard))

    def walks(self, part: int, shard: int) -> int:
        """Number of random walks of one shard."""
        rows, described = self.rows(part, shard), self.parts[part]
        if described.distribution.coats == 0:
            return 0
        return (rows.stop - rows.start) * described.pairs * described.walks

    def to_dict(self) -> dict[str, Any]:
        parts = [{**vars(part), "distribution": to_dict(part.distribution)} for part in self.parts]
        return {"parts": parts, "seed": self.seed, "shard": self.shard}
