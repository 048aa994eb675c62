"""BRDFs to represent: coloured stacks and conductors of Table 2, and measured materials.

The latter are files of RGL and MERL, and tables of neural fits that stand in for MERL's.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.evaluation import samples
from benchmarks.evaluation.distributions import Table2
from benchmarks.experiment import Options
from benchmarks.measures import Brdf
from benchmarks.rivals import nbrdf
from benchmarks.rivals.nbrdf import training_pairs

import urushi
from urushi.measured import Merl, load_measured
from urushi.measured.merl import SHAPE
from urushi.measured.tabulated import MeasuredSurface, bin_centres
from urushi.train.distribution import Extended
from urushi.walk import StackTable, analytic, walk_pairs

STACKS, CONDUCTORS, SEED = "two interfaces", "bare conductors", 31
MERL, RGL = "MERL stand-ins", "RGL"
#: Numbers of materials of each group. Measured ones are taken at even steps of the whole list.
COUNTS = {STACKS: 8, CONDUCTORS: 5, MERL: 4, RGL: 3}
#: Walks of a channel that a representation may spend on the values of a stack, in one call.
BUDGET = 1 << 20


@dataclass(frozen=True)
class Subject:
    """A BRDF to represent, as a function alone, so that no method knows its parameters."""

    name: str
    group: str  # one of `COUNTS`
    f: Brdf
    # Of a stack, `walked` of its table; None: f has no noise
    simulated: Callable[..., tuple[np.ndarray, np.ndarray]] | None = None


def subjects(options: Options) -> Iterator[Subject]:
    """All materials; measured ones are left out where there are no files."""
    rng = np.random.default_rng(SEED)
    table = coloured(Table2(1), rng, COUNTS[STACKS])
    for i in range(COUNTS[STACKS]):
        own = samples.part(table, slice(3 * i, 3 * i + 3))
        yield Subject(f"stack_{i}", STACKS, partial(spent, own, SEED + i), partial(walked, own))
    for i in range(COUNTS[CONDUCTORS]):
        alpha = rng.uniform(0.216, 1) ** 3
        conductor = urushi.conductor(alpha=alpha, r0=rng.uniform(0, 1, 3))
        yield Subject(f"conductor_{i}", CONDUCTORS, partial(analytic.f, conductor))
    files = materials(options.data())
    for group, kind in ((MERL, "stand-in"), (RGL, "RGL")):
        members = [measured for measured in files if measured.kind == kind]
        places = np.linspace(0, len(members) - 1, COUNTS[group]).astype(int) if members else ()
        for place in places:
            yield Subject(members[place].name, group, reciprocal(members[place].load()))


def walked(
    table: StackTable, wi: np.ndarray, wo: np.ndarray, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Values and their standard errors, (N, 3) each, of a table of one row for each channel."""
    row = np.tile(np.arange(3, dtype=np.uint32), len(wi))
    wi, wo = np.repeat(wi, 3, axis=0), np.repeat(wo, 3, axis=0)
    f, se = walk_pairs(table, row, wi, wo, walks=walks, seed=seed)
    return f.reshape(-1, 3), se.reshape(-1, 3)


def spent(table: StackTable, seed: int, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Values (N, 3) by `BUDGET` walks of each channel."""
    return walked(table, wi, wo, max(2, BUDGET // len(wi)), seed)[0]


def coloured(distribution: Table2 | Extended, rng: np.random.Generator, count: int) -> StackTable:
    """Stacks of three channels each, one after the other, with the same widths and indices."""
    table = distribution.sample(rng, 3 * count)
    shared = np.repeat(np.arange(count) * 3, 3)
    columns = {name: getattr(table, name) for name in ("albedo", "sigma_t", "g")}
    columns |= {name: getattr(table, name)[shared] for name in ("alpha", "eta")}
    bottom = {k: x[shared] if "alpha" in k else x for k, x in table.bottom.items()}
    return StackTable(**columns, kind=table.kind, bottom=bottom)


def training_set(
    materials: int, pairs: int, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs (M, P, 3) and values (M, P, 3) of other coloured stacks and of mixtures of lobes.

    One half is drawn by Table 2 and simulated, the other half are surfaces of a diffuse and two
    glossy lobes, as Urushi's own training has them; M = 2 `materials`.
    """
    rng, count = np.random.default_rng(seed), 2 * materials * pairs
    wi, wo = (w[:count].reshape(-1, pairs, 3) for w in training_pairs(rng, 3 * count))
    values = []
    for half, distribution in enumerate((Table2(1), Extended(0, "mixture"))):
        table = coloured(distribution, rng, materials)
        at = slice(half * materials, (half + 1) * materials)
        own_wi, own_wo = (np.repeat(w[at], 3, axis=0) for w in (wi, wo))
        found = samples.walk_all(table, own_wi, own_wo, walks, seed)[0]
        values.append(found.reshape(materials, 3, pairs).transpose(0, 2, 1))
    return wi, wo, np.concatenate(values)


@dataclass(frozen=True)
class Measured:
    """A measured material.

    Its file is one of MERL or RGL, or an archive (.npz) of networks of 675 weights by name. The
    table of the network `name` in MERL's bins stands in for a measured file.
    """

    name: str  # unique in its set
    path: Path

    @property
    def kind(self) -> str:
        return {".bsdf": "RGL", ".npz": "stand-in"}.get(self.path.suffix, "MERL")

    def load(self) -> MeasuredSurface:
        """The BRDF, as the walk samples it."""
        if self.path.suffix != ".npz":
            return load_measured(self.path)
        with np.load(self.path) as archive:
            weights = archive[self.name].astype(np.float64)
        angles = (a.ravel() for a in np.broadcast_arrays(*bin_centres(SHAPE)))
        table = nbrdf.unpacked(weights).at(nbrdf.vectors(*angles))
        return Merl(table.reshape(*SHAPE, 3))


def reciprocal(source: Any) -> Brdf:
    """f of a source, averaged over the exchange of wi and wo.

    RGL files are only as reciprocal as their measurement; most methods are exactly reciprocal, and
    an error that none of them can avoid would hide their differences.
    """
    return lambda wi, wo: 0.5 * (source.f(wi, wo) + source.f(wo, wi))


def materials(paths: Sequence[Path]) -> list[Measured]:
    """All materials of files, folders and archives."""
    found: list[Measured] = []
    for path in paths:
        if path.suffix == ".npz":
            with np.load(path) as archive:
                found += [Measured(name, path) for name in archive.files]
        else:
            files = sorted(path.iterdir()) if path.is_dir() else [path]
            found += [Measured(f.stem, f) for f in files if f.suffix in (".binary", ".bsdf")]
    return found


def coated(material: Any, coat: dict, layer: Callable[..., Any] = urushi.layer) -> Any:
    """The material under a coat; layer: of the material's system."""
    medium = {name: value for name, value in coat.items() if name not in ("alpha", "eta")}
    return layer(urushi.dielectric(coat["alpha"], coat["eta"]), material, **medium)
