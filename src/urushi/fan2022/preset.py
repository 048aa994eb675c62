"""The paper's set of materials, and the preset of its training, at full or smaller scale."""

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.fan2022.architecture import AdamProjection, PaperArchitecture
from urushi.fan2022.store import DataSpec, Part
from urushi.walk.table import StackTable

#: Pairs of direction strata in memory together, at most: bounds memory to some hundred MB.
SHARD_PAIRS = 1 << 21

#: The dielectric's row, the lower part's row, albedo and sigma_t of stacks, each (n,).
Stacked = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Palette:
    """Conductors, dielectrics, and stacks made of them (Fan et al. 2022, section 4.1).

    Parameters as in their Table 2. A stack of one coat is a random dielectric over a random
    conductor; a stack of two coats is a random dielectric over a random stack of one coat. The
    choice depends only on the seed and the row, so that a stack's components can be found in the
    other parts.
    """

    coats: int  # 0 for the components themselves, 1 or 2
    bottom: str = "conductor"  # without coats also "dielectric"
    components: int = 300  # number of dielectrics, and of conductors
    stacks: int = 12_720  # of one coat, from which the stacks of two coats are made
    seed: int = 0  # of all random choices and parameters

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


@dataclass(frozen=True)
class PaperPreset:
    """Data and schedules of Fan et al. 2022, section 4."""

    name: str  # the value of `--preset`
    scale: float  # share of the paper's number of training samples
    arch: PaperArchitecture
    data: DataSpec  # parts "conductor", "dielectric", "two-layer" and "three-layer"
    validation: int  # number of two-layer BRDFs, the last ones, that are not trained on
    epochs: int  # passes over the two-layer BRDFs
    decay: float  # factor on both rates after each epoch
    weights_rate: float  # Adam's learning rate of the evaluation network
    latents_rate: float  # and of the latents
    layering_epochs: int  # of the layering network
    finetuning_epochs: int  # of the layering network on the three-layer BRDFs
    proxy_materials: int  # materials that the sampling proxy learns from
    proxy_incoming: int  # incoming directions over which their histograms are averaged
    stacks: int = 64  # BRDFs in a step
    pairs: int = 64  # direction pairs of each
    layering_rate: float = 3e-3
    layering_decay: float = 0.7  # factor on the rate, twenty times
    finetuning_rate: float = 3e-4
    rows: int = 64  # layerings in a step
    seed: int = 0  # of the initial weights and of the order of the examples

    def part(self, name: str) -> Part:
        return next(part for part in self.data.parts if part.name == name)

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        arch = json.loads(self.arch.to_json())
        return asdict(self) | {"data": self.data.to_dict(), "arch": arch}


def paper(scale: float = 1.0, pairs: int = 16) -> PaperPreset:
    """Neural Layered BRDFs (Fan et al. 2022), trained as published or at a smaller scale.

    `scale` is the share of the paper's 2.3e11 training samples: BRDFs and epochs shrink by its
    fourth root, direction pairs by its square root. The total decay of the rates stays the same.
    The latents' rate is raised by the inverse square root of scale, at most a hundredfold, because
    the latents would otherwise stay near their initial value in the few steps. `pairs`: of each
    step of the projection, in training and later; the authors' number is 4,096.

    Command: `urushi train --preset paper --scale 4e-5`
    Time: half an hour on two cores at that scale, 214 minutes at 8e-4, 40 hours of a GPU at 1.
    Expected: at that scale no sharp highlights, and errors far above the paper's; the header of the
        weights file has the mean absolute errors of the projections.
    """
    if not 0 < scale <= 1:
        raise ParameterError(f"the paper preset's scale is {scale!r}; it must be in (0, 1]")
    fourth = scale**0.25

    def shrunk(count: int, least: int) -> int:
        return max(least, round(count * fourth))

    stratified = max(3, round(25 * scale**0.125)) ** 4
    components, stacks, epochs = shrunk(300, 4), shrunk(12_720, 16), shrunk(50, 1)

    def part(name: str, coats: int, count: int, bottom: str = "conductor") -> Part:
        source = Palette(coats, bottom, components, stacks)
        return Part(name, source, count, stratified, 256 if coats else 1)

    parts = (
        part("conductor", 0, components),
        part("dielectric", 0, components, "dielectric"),
        part("two-layer", 1, stacks),
        part("three-layer", 2, shrunk(1_800, 4)),
    )
    return PaperPreset(
        name="paper",
        scale=scale,
        arch=PaperArchitecture(AdamProjection(pairs=pairs)),
        data=DataSpec(parts, seed=1, shard=max(1, min(256, SHARD_PAIRS // stratified))),
        validation=shrunk(720, 4),
        epochs=epochs,
        decay=0.9 ** (50 / epochs),
        weights_rate=3e-4,
        latents_rate=1e-4 * min(100.0, scale**-0.5),
        layering_epochs=shrunk(1_000, 20),
        finetuning_epochs=shrunk(100, 2),
        proxy_materials=shrunk(1_024, 4),
        proxy_incoming=max(4, round(1_600 * scale**0.5)),
    )
