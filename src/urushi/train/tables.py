"""Training data: random stacks by light transport, at the nodes of `core.table`.

Every stack is computed coat by coat, and all levels are kept: the bare bottom, and what lies below
each of its coats. Further random coats are computed over every level, at the probe pairs only: the
layering network learns from them. Levels of several stacks share interfaces and media of these
coats, so that a coat costs a third. The data lie in shards. Each is written once and as a whole, so
that an interrupted run continues where it stopped, with the same result.
"""

import hashlib
import json
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from urushi import files
from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import MIN_LOG, SHAPE, completed, known_nodes, node_pairs, table_of_values
from urushi.errors import FileError
from urushi.material.coated_values import coated_f
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.parallel import one_blas_thread
from urushi.platform import available_cores
from urushi.train.bottoms import bottom_lobes, bottom_rest
from urushi.train.distribution import Extended, Practical
from urushi.walk.bottoms import KINDS
from urushi.walk.table import StackTable

FORMAT_VERSION = 1

#: Bottoms of stacks, with their shares.
SHARES = {
    "conductor": 0.2,
    "conductor_complex": 0.15,
    "dielectric": 0.12,
    "diffuse": 0.08,
    "mixture": 0.3,
    "measured_like": 0.15,
}

#: Shares of stacks without coats, with one, two and three.
COATS = 0.1, 0.5, 0.3, 0.1

#: Share of the stacks and coats that are `Practical`; the others are spread over the whole domain.
PRACTICAL = 0.75

#: Levels under the same further coats, coats over them, and coats of the same interface.
BOTTOMS, TOGETHER, SHARED = 8, 16, 2

#: Difference of an absolute index from 1 that is rounding.
ROUNDING = 1e-4


@dataclass(frozen=True)
class TableSpec:
    """What a folder of tables holds."""

    stacks: int
    coats: int  # further random coats over every level of a stack, a multiple of 16 is cheapest
    probes: int  # number of probe pairs
    seed: int = 0
    shard: int = 25  # stacks of a file

    def shards(self) -> int:
        """The number of files."""
        return -(-self.stacks // self.shard)


@dataclass(frozen=True)
class TableStore:
    """A folder of tables. Rows are levels of stacks, from the bottom up; arrays of a shard:

    - table: float16 (R, P), ln f of the rest at the nodes; `MIN_LOG` where there is none;
    - lobe: float32 (R, L), the lobes beside it;
    - stack, kind, level: int32 (R,), number of the stack, kind of its bottom (of `SHARES`), and
      number of coats of this level;
    - low: float32 (R,), the least absolute index of its media, seen from the medium above it;
    - coat: float32 (R, 5), the topmost coat, `CoatParameters`; zeros for bare bottoms;
    - over: float32 (R, C, 5), further coats;
    - coated: float32 (R, C, N), ln f of the rests under these coats at the probe pairs.
    """

    path: Path
    spec: TableSpec

    def file(self, shard: int) -> Path:
        """The file of a shard."""
        return self.path / f"{shard:05}.safetensors"

    def missing(self) -> list[int]:
        """Shards that are still to be computed."""
        return [k for k in range(self.spec.shards()) if not self.file(k).exists()]

    def read(self, names: Sequence[str]) -> dict[str, np.ndarray]:
        """Arrays by name, of all shards one after another."""
        parts = [
            files.read_tensors(self.file(k), "tables", FORMAT_VERSION, names)[1]
            for k in range(self.spec.shards())
        ]
        return {name: np.concatenate([part[name] for part in parts]) for name in names}

    def hash(self) -> str:
        """SHA-256 over the specification and all tables."""
        digest = hashlib.sha256(json.dumps(asdict(self.spec), sort_keys=True).encode())
        for shard in range(self.spec.shards()):
            digest.update(self.file(shard).read_bytes())
        return digest.hexdigest()


def generate(spec: TableSpec, path: str | os.PathLike) -> TableStore:
    """Compute the tables of `spec` in a folder, or complete them, with a process on every core."""
    store = opened(spec, Path(path))
    missing = store.missing()
    if not missing:
        return store
    with (
        ProcessPoolExecutor(available_cores(), get_context("spawn")) as pool,
        tqdm(total=len(missing) * spec.shard, desc="tables", disable=None) as progress,
    ):
        for done in as_completed([pool.submit(write_shard, store, shard) for shard in missing]):
            done.result()
            progress.update(spec.shard)
    return store


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


def write_shard(store: TableStore, shard: int) -> None:
    """Compute one shard and write it."""
    with one_blas_thread():
        arrays = make_shard(store.spec, shard)
    files.write_tensors(store.file(shard), "tables", {"version": FORMAT_VERSION}, arrays)


def make_shard(spec: TableSpec, shard: int) -> dict[str, np.ndarray]:
    """The arrays of a shard; they depend on the arguments alone."""
    first = shard * spec.shard
    numbers = range(first, min(first + spec.shard, spec.stacks))
    rows = [row for number in numbers for row in levels(spec.seed, number)]
    arrays = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    rng = np.random.default_rng([spec.seed, shard, len(rows)])
    arrays["over"] = np.empty((len(rows), spec.coats, 5), np.float32)
    arrays["coated"] = np.empty((len(rows), spec.coats, spec.probes), np.float32)
    for start in range(0, spec.coats, TOGETHER):
        place = slice(start, min(start + TOGETHER, spec.coats))
        groups = np.array_split(rng.permutation(len(rows)), -(-len(rows) // BOTTOMS))
        for group in groups:
            over = draw_coats(rng, place.stop - place.start)
            below = _substrate(arrays["table"][group], arrays["lobe"][group])
            arrays["over"][group, place] = over
            arrays["coated"][group, place] = _at_probes(below, over, spec.probes)
    return arrays


def levels(seed: int, number: int) -> list[dict[str, Any]]:
    """The rows of one stack without further coats, see `TableStore`."""
    stack = draw_stack(np.random.default_rng([seed, number]))
    bottom = np.stack([stack.bottom[name] for name in KINDS[stack.kind].parameters], axis=-1)
    lobe = bottom_lobes(stack.kind, bottom)
    rest = bottom_rest(stack.kind, bottom, lobe, *node_pairs())
    logs, coats = table_of_values(rest.T).reshape(1, -1), _coats(stack)
    rows, low = [], 1.0
    for level in range(stack.coats + 1):
        coat = np.zeros(5)
        if level:
            coat = coats[-level]
            lobe, logs = coated(_substrate(logs, lobe), coat)
            low = min(coat[1], coat[1] * low)
        rows.append(
            {
                "table": logs[0],
                "lobe": lobe[0],
                "stack": np.int32(number),
                "kind": np.int32(list(SHARES).index(stack.kind)),
                "level": np.int32(level),
                "low": np.float32(low if level else 1),
                "coat": coat.astype(np.float32),
            }
        )
    return rows


def draw_stack(rng: np.random.Generator) -> StackTable:
    """One random stack whose absolute indices are at least 1."""
    kind = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    coats = int(rng.choice(len(COATS), p=COATS))
    while True:
        practical = coats and rng.random() < PRACTICAL
        stack = (Practical(coats, kind) if practical else _whole(coats, kind)).sample(rng, 1)
        if not coats or np.cumprod(stack.eta[0]).min() > 1 - ROUNDING:
            return stack


def draw_coats(rng: np.random.Generator, count: int) -> np.ndarray:
    """Random coats (count, 5) with any index, `SHARED` after another with the same interface."""
    often = rng.binomial(count, PRACTICAL)
    parts = (Practical(1), often), (_whole(1, "conductor"), count - often)
    coats = np.concatenate([_coats(drawn.sample(rng, number)) for drawn, number in parts])
    coats = rng.permutation(coats)
    coats[:, :2] = coats[np.arange(count) // SHARED * SHARED, :2]
    return coats


def _whole(coats: int, kind: str) -> Extended:
    return Extended(coats, kind, indices="whole")


def _coats(stack: StackTable) -> np.ndarray:
    """The coats (S N, 5) of stacks, from top to bottom."""
    columns = [np.asarray(getattr(stack, name)).ravel() for name in CoatParameters._fields]
    return np.stack(columns, axis=-1).astype(np.float64)


def coated(below: Substrate, coat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lobe (1, L) and table (1, P) of a material under a coat (5,)."""
    rows = np.ix_(*known_nodes(()))
    pairs = (w.reshape(*SHAPE, 3)[rows].reshape(-1, 3) for w in node_pairs())
    f = coated_f(below, CoatParameters(*coat[:, None]), *pairs)
    values = completed(f.reshape(*(row.size for row in rows), SHAPE[2], 1), ())
    own = lobes.of_coat(*coat[:2, None]).astype(np.float32)
    return own, table_of_values(values.reshape(-1, 1)).reshape(1, -1)


def _substrate(tables: np.ndarray, lobe: np.ndarray) -> Substrate:
    """Materials with tables (B, P) beside lobes (B, L)."""
    return Substrate.of_logs(np.moveaxis(tables.reshape(-1, *SHAPE), 0, -1), lobe)


def _at_probes(below: Substrate, coats: np.ndarray, count: int) -> np.ndarray:
    """ln f float32 (B, C, N) of the rests of materials B under coats (C, 5) at the probe pairs."""
    f = coated_f(below, CoatParameters(*coats.T[..., None]), *probe_pairs(count))  # (N, C, B)
    return np.log(np.maximum(f.T, np.exp(MIN_LOG))).astype(np.float32)
