"""Training data: random stacks by light transport, at the nodes of `core.table`.

Every stack is computed coat by coat, and all levels are kept: the bare bottom, and what lies below
each of its coats. Further random coats are computed over every level, at the probe pairs only: the
layering network learns from them. Several levels share the interfaces and media of these coats,
which lowers the cost of a coat to a third. The data lie in shards. Each is written once and as a
whole, so that an interrupted run continues where it stopped, with the same result.
"""

import functools
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from urushi import files
from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import (
    SHAPE,
    interpolated_nodes,
    known_nodes,
    known_pairs,
    node_pairs,
    table_of_values,
)
from urushi.errors import FileError
from urushi.material.coated_values import coated_g
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.nets import weights
from urushi.nets.transmittance import remainder
from urushi.train import stretched_tables, workers
from urushi.train.basis_fit import bottom_codes
from urushi.train.distribution import bottom_lobes, coats_of, draw_coats, draw_stack
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS

FORMAT_VERSION = 1

#: Levels under the same further coats, and coats over them.
BOTTOMS, TOGETHER = 8, 16

#: The arrays of a shard by name.
Arrays = dict[str, np.ndarray]


@dataclass(frozen=True)
class TableSpec:
    """What a folder of tables holds."""

    stacks: int
    coats: int  # further random coats over every level of a stack, a multiple of 16 is cheapest
    probes: int  # number of probe pairs
    seed: int = 0
    shard: int = 25  # stacks of a file
    widths: int = 1  # GGX widths of a surface

    def shards(self) -> int:
        """The number of files."""
        return -(-self.stacks // self.shard)


@dataclass(frozen=True)
class TableStore:
    """A folder of tables. Rows are levels of stacks, from the bottom up; arrays of a shard:

    - table: float16 (R, P), ln g of `nets.transmittance` at the nodes; `MIN_LOG` where f is the
      lobe alone;
    - lobe: float32 (R, L), the lobes beside it;
    - stack, kind, level: int32 (R,), number of the stack, kind of its bottom (of `SHARES`), and
      number of coats of this level;
    - coat: float32 (R, 5), the topmost coat, `CoatParameters`; zeros for bare bottoms;
    - over: float32 (R, C, 5), further coats;
    - coated: float32 (R, C, N), ln g under these coats at the probe pairs.

    Those of two widths are described in `stretched_tables`.
    """

    path: Path
    spec: TableSpec

    def file(self, shard: int) -> Path:
        """The file of a shard."""
        return self.path / f"{shard:05}.safetensors"

    def missing(self) -> list[int]:
        """Shards that are still to be computed."""
        return [k for k in range(self.spec.shards()) if not self.file(k).exists()]

    def shard(self, shard: int, names: Sequence[str]) -> Arrays:
        """Arrays (R, ...) of a shard by name."""
        return files.read_tensors(self.file(shard), "tables", FORMAT_VERSION, names)[1]

    def read(self, names: Sequence[str]) -> Arrays:
        """Arrays (R, ...) by name, of the rows of all shards one after another."""
        parts = [self.shard(k, names) for k in range(self.spec.shards())]
        return {name: np.concatenate([part[name] for part in parts]) for name in names}

    def hash(self) -> str:
        """SHA-256 over the specification and all tables."""
        digest = hashlib.sha256(json.dumps(asdict(self.spec), sort_keys=True).encode())
        for shard in range(self.spec.shards()):
            digest.update(self.file(shard).read_bytes())
        return digest.hexdigest()

    def complete(
        self, make: Callable[[Any], Arrays], tasks: Iterable[tuple[Any, ...]], cluster: str | None
    ) -> "TableStore":
        """Write the shards of tasks, each once and as a whole. Only this process writes.

        make: the arrays of a shard by its task. tasks: numbers of shards, and more arguments.
        cluster: where they are computed, see `workers.results`.
        """
        total = len(self.missing()) * self.spec.shard
        with tqdm(total=total, desc="tables", disable=None) as progress:
            for (shard, *_), arrays in workers.results(make, tasks, cluster):
                files.write_tensors(self.file(shard), "tables", {"version": FORMAT_VERSION}, arrays)
                progress.update(self.spec.shard)
        return self


def opened(spec: TableSpec, path: Path) -> TableStore:
    """The store at a path, which is empty or has the same specification."""
    files.new_folder(path)
    described, manifest = asdict(spec), path / "tables.json"
    if not manifest.exists():
        with files.atomic_write(manifest) as temporary:
            temporary.write_text(json.dumps(described, indent=1), encoding="utf-8")
    try:
        found = json.loads(manifest.read_text(encoding="utf-8"))
    except ValueError:
        found = None
    if found != described:
        raise FileError(
            f"'{path}' has tables of another specification; delete it or choose another folder"
        )
    return TableStore(path, spec)


def generate(
    spec: TableSpec,
    path: str | os.PathLike,
    make: Callable[[TableSpec, int], Arrays] | None = None,
    cluster: str | None = None,
) -> TableStore:
    """Compute the tables of `spec` in a folder, or complete them.

    make: the arrays of a shard; default `make_shard`.
    cluster: where they are computed, see `workers.results`; default a process on every core.
    """
    store = opened(spec, Path(path))
    compute = functools.partial(_made, make or make_shard, spec)
    return store.complete(compute, zip(store.missing()), cluster)


def _made(make: Callable[[TableSpec, int], Arrays], spec: TableSpec, task: tuple[int]) -> Arrays:
    return make(spec, *task)


def generate_coats(
    store: TableStore, model: weights.Model, cluster: str | None = None
) -> TableStore:
    """The store of further coats over the codes of a store of two widths, with "bottom" (R, L).

    model: with the basis of the codes. cluster: as of `generate`.
    """
    coats = opened(store.spec, store.path / f"coats-{model.fingerprint}")

    def below(shard: int) -> tuple[int, np.ndarray, np.ndarray]:
        held = store.shard(shard, ("lobe", "probes", "stack"))
        return shard, held["stack"], bottom_codes(model, held)

    make = functools.partial(stretched_tables.coats_over, model.arch, model.params, store.spec)
    return coats.complete(make, map(below, coats.missing()), cluster)


def make_shard(spec: TableSpec, shard: int) -> Arrays:
    """The arrays of a shard; they depend on the arguments alone."""
    numbers = range(shard * spec.shard, min((shard + 1) * spec.shard, spec.stacks))
    if spec.widths == 2:
        rows = [r for n in numbers for r in stretched_tables.levels(spec.probes, spec.seed, n)]
    else:
        rows = [row for number in numbers for row in levels(spec.seed, number)]
    arrays = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    if spec.widths == 2:
        return arrays
    rng = np.random.default_rng([spec.seed, shard, len(rows)])
    arrays["over"] = np.empty((len(rows), spec.coats, 5), np.float32)
    arrays["coated"] = np.empty((len(rows), spec.coats, spec.probes), np.float32)
    for start in range(0, spec.coats, TOGETHER):
        place = slice(start, min(start + TOGETHER, spec.coats))
        for group in np.array_split(rng.permutation(len(rows)), -(-len(rows) // BOTTOMS)):
            over = draw_coats(rng, place.stop - place.start)
            below = _substrate(arrays["table"][group], arrays["lobe"][group])
            coats = CoatParameters(*over.T[..., None])
            g = coated_g(below, coats, *probe_pairs(spec.probes))  # (N, coats, group)
            arrays["over"][group, place] = over
            arrays["coated"][group, place] = stretched_tables.logs(g.T)
    return arrays


def levels(seed: int, number: int) -> list[Arrays]:
    """The rows of one stack without further coats, see `TableStore`."""
    stack = draw_stack(np.random.default_rng([seed, number]))
    lobe, pairs = bottom_lobes(stack.kind, stack.bottom), node_pairs()
    rest = np.zeros((1, len(pairs[0])), np.float32)
    if not KINDS[stack.kind].family.bare:
        values = analytic.at_all(stack.kind, stack.bottom, *pairs)
        rest = remainder(values, lobe[:, None], *pairs)
    logs = table_of_values(rest.T).reshape(1, -1)
    coat, rows = np.zeros(5), []
    for level, above in enumerate([None, *coats_of(stack)[::-1]]):
        if above is not None:
            coat = above
            g = coated_g(_substrate(logs, lobe), CoatParameters(*coat[:, None]), *known_pairs())
            known = np.float32(g).reshape(*map(len, known_nodes(())), SHAPE[2])
            logs = table_of_values(interpolated_nodes(known, ()).reshape(-1, 1)).reshape(1, -1)
            lobe = lobes.of_coat(*coat[:2, None]).astype(np.float32)
        rows.append(stretched_tables.row_of(stack, number, level, coat, lobe[0], logs[0]))
    return rows


def _substrate(tables: np.ndarray, lobe: np.ndarray) -> Substrate:
    """Materials with tables (B, P) beside lobes (B, L)."""
    return Substrate.of(Reflector.of_logs(np.moveaxis(tables.reshape(-1, *SHAPE), 0, -1), lobe))
