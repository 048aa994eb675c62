"""The paper's set of materials: stacks composed of a few hundred interfaces."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from urushi.errors import ParameterError
from urushi.walk.table import StackTable

#: The dielectric's row, the lower part's row, albedo and sigma_t of stacks, each (n,).
Stacked = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Palette:
    """Conductors, dielectrics, and stacks made of them (Fan et al. 2022, section 4.1).

    Parameters as in their Table 2. A stack of one coat is a random dielectric over a random
    conductor; a stack of two coats is a random dielectric over a random stack of one coat. The
    choice depends only on the seed and the row, so that a stack's components can be found in the
    other parts.

    Attributes:
        coats: 0 for the components themselves, 1 or 2.
        bottom: "conductor"; without coats also "dielectric".
        components: number of dielectrics, and of conductors.
        stacks: number of stacks of one coat, from which the stacks of two coats are made.
        seed: of all random choices and parameters.
    """

    coats: int
    bottom: str = "conductor"
    components: int = 300
    stacks: int = 12_720
    seed: int = 0
    widths: ClassVar[int] = 1

    def __post_init__(self) -> None:
        kinds = ("conductor", "dielectric") if self.coats == 0 else ("conductor",)
        if self.coats not in (0, 1, 2) or self.bottom not in kinds:
            raise ParameterError(
                f"the paper's materials have no stacks of {self.coats!r} coats over "
                f"{self.bottom!r}; give 0, 1 or 2 coats over 'conductor', or 0 and 'dielectric'"
            )
        if min(self.components, self.stacks) < 1:
            raise ParameterError("the paper's materials need at least one component and one stack")

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable:
        """The stacks of some rows; `rng` is not needed."""
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
        alpha = 0.216 + (1 - 0.216) * self._uniform(first, self.components)
        other = self._uniform(first + 1, self.components)
        if kind == "dielectric":
            other = 1.05 + 0.95 * other
        return alpha[index] ** 3, other[index]

    def _stacked(self, level: int, index: np.ndarray) -> Stacked:
        count, first = int(index.max(initial=-1)) + 1, 4 * level
        lower = self.components if level == 1 else self.stacks
        u = [self._uniform(first + column, count)[index] for column in range(4)]
        top, below = (self.components * u[0]).astype(int), (lower * u[1]).astype(int)
        return top, below, 1 - u[2] ** 2, np.array([0.0, 1.0, 2.0, 5.0])[(4 * u[3]).astype(int)]

    def _uniform(self, column: int, count: int) -> np.ndarray:
        """The first `count` numbers in [0, 1) of a column."""
        seeds = np.random.SeedSequence(self.seed, spawn_key=(column,))
        return np.random.default_rng(seeds).random(count)
