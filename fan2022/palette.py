"""The paper's materials and training data: stacks of Table 2, simulated in strata of directions."""

from dataclasses import dataclass

import numpy as np

from fan2022.pairs import stratified_pairs
from urushi import files
from urushi.train.tables import FORMAT_VERSION, Arrays, TableStore
from urushi.walk import analytic
from urushi.walk.simulate import walk_pairs
from urushi.walk.table import StackTable

#: Pairs of direction strata in memory together, at most: bounds memory to some hundred MB.
SHARD_PAIRS = 1 << 21

#: Random walks of a pair; bottoms without a coat are analytic and need none.
WALKS = 256

#: The dielectric's row, the lower part's row, albedo and sigma_t of stacks, each (n,).
Stacked = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Palette:
    """Conductors, dielectrics, and stacks made of them (Fan et al. 2022, section 4.1).

    Parameters as in their Table 2. A stack of one coat is a random dielectric over a random
    conductor; a stack of two coats is a random dielectric over a random stack of one coat. The
    choice depends only on the row, so that a stack's components can be found in the other parts.
    """

    coats: int  # 0 for the components themselves, 1 or 2
    bottom: str = "conductor"  # without coats also "dielectric"
    components: int = 300  # number of dielectrics, and of conductors
    stacks: int = 12_720  # of one coat, from which the stacks of two coats are made

    def draw(self, rows: slice) -> StackTable:
        """The stacks of some rows."""
        coats: dict[str, list[np.ndarray]] = {k: [] for k in ("alpha", "eta", "albedo", "sigma_t")}
        index = np.arange(rows.start, rows.stop)
        for level in range(self.coats, 0, -1):
            top, index, albedo, sigma_t = self._stacked(level, index)
            columns = (*self._interface("dielectric", top), albedo, sigma_t)
            for column, values in zip(coats.values(), columns, strict=True):
                column.append(values)
        no_coats = np.zeros((len(index), 0))
        table = {k: np.stack(v, axis=1) if v else no_coats for k, v in coats.items()}
        names = ("alpha", "r0") if self.bottom == "conductor" else ("alpha", "eta")
        bottom = dict(zip(names, self._interface(self.bottom, index), strict=True))
        return StackTable(**table, g=np.zeros_like(table["alpha"]), kind=self.bottom, bottom=bottom)

    def parts(self, rows: slice) -> Stacked:
        """The components of some rows' stacks.

        The lower part is a conductor under one coat, and a stack of one coat under two coats.
        """
        return self._stacked(self.coats, np.arange(rows.start, rows.stop))

    def _interface(self, kind: str, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first = 0 if kind == "dielectric" else 2
        alpha = 0.216 + (1 - 0.216) * _uniform(first, self.components)
        other = _uniform(first + 1, self.components)
        if kind == "dielectric":
            other = 1.05 + 0.95 * other
        return alpha[index] ** 3, other[index]

    def _stacked(self, level: int, index: np.ndarray) -> Stacked:
        count, first = int(index.max(initial=-1)) + 1, 4 * level
        lower = self.components if level == 1 else self.stacks
        u = [_uniform(first + column, count)[index] for column in range(4)]
        top, below = (self.components * u[0]).astype(int), (lower * u[1]).astype(int)
        return top, below, 1 - u[2] ** 2, np.array([0.0, 1.0, 2.0, 5.0])[(4 * u[3]).astype(int)]


def _uniform(column: int, count: int) -> np.ndarray:
    """The first `count` numbers in [0, 1) of a column."""
    seeds = np.random.SeedSequence(0, spawn_key=(column,))
    return np.random.default_rng(seeds).random(count)


@dataclass(frozen=True)
class PaperData:
    """What a folder of training data holds: stacks of four parts, each at pairs of its own.

    A shard, one file, has of its stacks the pairs wi, wo (S, P, 3) and the BRDF f (S, P) [1/sr].
    Shards are numbered through all parts. `train.tables.generate` makes them.
    """

    components: int = 300
    two_layer: int = 12_720
    three_layer: int = 1_800
    pairs: int = 25**4  # of a stack, one in each stratum
    seed: int = 1  # of directions and walks

    @property
    def shard(self) -> int:
        """Stacks of a shard; the last one of a part may have fewer."""
        return max(1, min(256, SHARD_PAIRS // self.pairs))

    @property
    def parts(self) -> dict[str, tuple[Palette, int]]:
        """Source and number of stacks of each part."""
        sizes = self.components, self.two_layer
        return {
            "conductor": (Palette(0, "conductor", *sizes), self.components),
            "dielectric": (Palette(0, "dielectric", *sizes), self.components),
            "two-layer": (Palette(1, "conductor", *sizes), self.two_layer),
            "three-layer": (Palette(2, "conductor", *sizes), self.three_layer),
        }

    def places(self) -> list[tuple[str, slice]]:
        """The part of each shard, and its rows in the part."""
        return [
            (name, slice(start, min(start + self.shard, count)))
            for name, (_, count) in self.parts.items()
            for start in range(0, count, self.shard)
        ]

    def shards(self) -> int:
        """The number of files."""
        return len(self.places())


def make_shard(data: PaperData, shard: int) -> Arrays:
    """Draw and simulate the stacks of one shard; the result depends only on the arguments."""
    name, rows = data.places()[shard]
    part, index = list(data.parts).index(name), rows.start // data.shard
    seeds = np.random.SeedSequence(data.seed, spawn_key=(part, index))
    _, directions, walks = seeds.spawn(3)
    rng, count = np.random.default_rng(directions), rows.stop - rows.start
    drawn = [stratified_pairs(rng, data.pairs) for _ in range(count)]
    wi, wo = (np.concatenate(sides) for sides in zip(*drawn, strict=True))
    table = data.parts[name][0].draw(rows)
    row = np.repeat(np.arange(count, dtype=np.uint32), data.pairs)
    if table.coats:
        seed = int(walks.generate_state(1)[0])
        f, _ = walk_pairs(table, row, wi, wo, walks=WALKS, seed=seed)
    else:
        f = analytic.rows(table.kind, table.bottom, row, wi, wo)
    shapes = (count, -1, 3), (count, -1, 3), (count, -1)
    return {n: x.reshape(s) for n, x, s in zip(("wi", "wo", "f"), (wi, wo, f), shapes, strict=True)}


def read_shard(store: TableStore, shard: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """wi, wo and f of a shard."""
    names = ("wi", "wo", "f")
    _, arrays = files.read_tensors(store.file(shard), "tables", FORMAT_VERSION, names)
    return arrays["wi"], arrays["wo"], arrays["f"]
