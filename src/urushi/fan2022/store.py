"""The store of simulated BRDF values: its specification, its files and its simulation.

A store is a folder. `store.json` has its specification; every shard is one file,
`PART/NUMBER.safetensors`, of these arrays, whose first axis is the stack:

    coats   (S, N, C)  the coats' `checks.COAT_COLUMNS`, top to bottom (none if N = 0)
    bottom  (S, K)     the parameters of the bottom's kind, in its order
    wi, wo  (S, P, 3)  unit direction pairs, float32
    f, se   (S, P)     BRDF value [1/sr] and its standard error

Files are written whole. If the writer is killed, the store can be resumed.
"""

import hashlib
import json
import os
import platform
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from tqdm import tqdm

from urushi import files
from urushi.checks import CoatParameters
from urushi.core.direction_sets import Pairs, cosine_pairs, stratified_pairs
from urushi.errors import FileError, ParameterError
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS
from urushi.walk.simulate import walk_pairs
from urushi.walk.table import StackTable

FORMAT_VERSION = 2

#: A shard: the arrays of the layout above for its stacks.
Shard = Mapping[str, np.ndarray]


class Source(Protocol):
    """A source of stacks: a frozen dataclass."""

    @property
    def coats(self) -> int: ...  # of every stack

    @property
    def bottom(self) -> str: ...  # the kind of every stack's bottom, a key of `KINDS`

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable: ...


@dataclass(frozen=True)
class Part:
    """Stacks of one source, with the direction pairs at which each is simulated."""

    name: str  # unique in the store
    distribution: Source
    stacks: int
    pairs: int  # direction pairs of a stack; every stack has its own
    walks: int  # random walks of a pair; bottoms without a coat are analytic and need none
    directions: str = "stratified"  # of the pairs, or "cosine", see `core.direction_sets`

    def __post_init__(self) -> None:
        for name in ("stacks", "pairs", "walks"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 1:
                raise ParameterError(
                    f"part '{self.name}' has {name} = {value!r}; give a positive integer"
                )
        if self.directions not in ("stratified", "cosine"):
            raise ParameterError(
                f"part '{self.name}' has directions = {self.directions!r}; "
                "choose stratified or cosine"
            )
        if self.directions == "stratified" and round(self.pairs**0.25) ** 4 != self.pairs:
            raise ParameterError(
                f"part '{self.name}' has {self.pairs} stratified pairs; "
                "give a fourth power, such as 625"
            )

    def draw_pairs(self, rng: np.random.Generator, stacks: int) -> Pairs:
        """The pairs of several stacks, one after the other: (stacks * pairs, 3) twice."""
        if self.directions == "cosine":
            return cosine_pairs(rng, stacks * self.pairs)
        drawn = [stratified_pairs(rng, self.pairs) for _ in range(stacks)]
        wi, wo = (np.concatenate(sides) for sides in zip(*drawn, strict=True))
        return wi, wo

    def to_dict(self) -> dict[str, Any]:
        kind = type(self.distribution).__name__.lower()
        return {**vars(self), "distribution": {"kind": kind, **vars(self.distribution)}}


@dataclass(frozen=True)
class DataSpec:
    """The specification of a data store, which its manifest and a preset contain."""

    parts: tuple[Part, ...]  # in the order of generation
    seed: int = 0  # of parameters, directions and walks
    shard: int = 256  # number of stacks that are drawn, simulated and written together

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
        parts = [part.to_dict() for part in self.parts]
        return {"parts": parts, "seed": self.seed, "shard": self.shard}


@dataclass(frozen=True)
class Store:
    """A data store on disk, with its folder and the content of the complete store."""

    path: Path
    spec: DataSpec

    @classmethod
    def create(cls, path: str | os.PathLike, spec: DataSpec) -> "Store":
        """Make an empty store, or open an existing one of the same specification to resume it."""
        folder, wanted = Path(path), json.loads(json.dumps(spec.to_dict()))
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            found = _description(folder)
            if found != wanted:
                raise FileError(
                    f"'{folder}' contains data of another specification "
                    f"({_difference(found, wanted)}); choose another path or delete that folder"
                )
            for stray in folder.rglob(".*-*"):  # left by a writer that was killed
                stray.unlink()
            return cls(folder, spec)
        files.new_folder(folder)
        packages = {name: version(name) for name in ("urushi", "numpy", "drjit")}
        versions = {"python": platform.python_version(), **packages}
        manifest = {"format_version": FORMAT_VERSION, "spec": wanted, "versions": versions}
        with files.atomic_write(folder / "store.json") as temporary:
            temporary.write_text(json.dumps(manifest, indent=1), encoding="utf-8")
        return cls(folder, spec)

    def missing(self) -> list[tuple[int, int]]:
        """The (part, shard) indices whose files are missing or cut short, in order."""
        return [index for index in self.spec.shards() if not self._is_whole(*index)]

    def _is_whole(self, part: int, shard: int) -> bool:
        """Whether a shard's file has the length that it states, as an interrupted copy has not."""
        try:
            files.read_tensors(self._file(part, shard), "data", names=())
        except FileError:
            return False
        return True

    def write(self, part: int, shard: int, arrays: Shard) -> None:
        """Write one shard."""
        file = self._file(part, shard)
        files.new_folder(file.parent)
        single = {name: np.asarray(values, np.float32) for name, values in arrays.items()}
        files.write_tensors(file, "data", {}, single)

    def read(self, part: Part) -> dict[str, np.ndarray]:
        """Read all arrays of a complete part into memory."""
        index = self.spec.parts.index(part)
        shards = [self.read_shard(index, k) for k in range(self.spec.shard_count(part))]
        return {name: np.concatenate([shard[name] for shard in shards]) for name in shards[0]}

    def read_shard(
        self, part: int, shard: int, names: Collection[str] | None = None
    ) -> dict[str, np.ndarray]:
        """Read one shard; names: of the arrays, where it has them; None: all."""
        file, described = self._file(part, shard), self.spec.parts[part]
        if not file.exists():
            count = self.spec.shard_count(described)
            found = sum(self._file(part, k).exists() for k in range(count))
            raise FileError(
                f"'{self.path}' is incomplete: part '{described.name}' has {found} of {count} "
                "shards; resume it with `urushi data`"
            )
        _, arrays = files.read_tensors(file, "data", names=names)
        if not all(np.isfinite(values).all() for values in arrays.values()):
            raise FileError(
                f"'{file}' is damaged: it has values that are not finite; delete it and resume "
                "with `urushi data`"
            )
        return arrays

    def hash(self) -> str:
        """SHA-256 over the specification and all values f, recorded in the weights' header."""
        digest = hashlib.sha256(json.dumps(self.spec.to_dict(), sort_keys=True).encode())
        for part, shard in self.spec.shards():
            f = self.read_shard(part, shard, ("f",))["f"]
            digest.update(np.ascontiguousarray(f).tobytes())
        return digest.hexdigest()

    def _file(self, part: int, shard: int) -> Path:
        return self.path / self.spec.parts[part].name / f"{shard:05}.safetensors"


def make_shard(spec: DataSpec, part: int, shard: int) -> Shard:
    """Draw and simulate the stacks of one shard; the result depends only on the arguments.

    part, shard: indices of the part and of its shard.
    """
    described = spec.parts[part]
    rows = spec.rows(part, shard)
    count = rows.stop - rows.start
    parameters, directions, walks = spec.seeds(part, shard).spawn(3)
    table = described.distribution.draw(np.random.default_rng(parameters), rows)
    rng = np.random.default_rng(directions)
    wi, wo = described.draw_pairs(rng, count)
    row = np.repeat(np.arange(count, dtype=np.uint32), described.pairs)
    if described.distribution.coats == 0:
        f = analytic.rows(table.kind, table.bottom, row, wi, wo)
        se = np.zeros_like(f)
    else:
        seed = int(walks.generate_state(1)[0])
        f, se = walk_pairs(table, row, wi, wo, walks=described.walks, seed=seed)
    arrays = {
        "bottom": np.stack([table.bottom[name] for name in KINDS[table.kind].parameters], axis=-1),
        "wi": wi.reshape(count, -1, 3),
        "wo": wo.reshape(count, -1, 3),
        "f": f.reshape(count, -1),
        "se": se.reshape(count, -1),
    }
    if described.distribution.coats:
        coats = CoatParameters(*(getattr(table, name) for name in CoatParameters._fields))
        arrays["coats"] = np.stack(coats.columns(), axis=-1)
    return arrays


def generate(spec: DataSpec, path: str | os.PathLike) -> Store:
    """Generate the data of `spec` at `path`, or resume where an earlier run was stopped.

    The bytes of the result do not depend on interruptions. Only this process writes to the folder.
    """
    store = Store.create(path, spec)
    missing = store.missing()
    total = sum(spec.walks(*index) for index in missing)
    with tqdm(total=total, unit="walk", unit_scale=True, disable=None) as progress:
        for part, shard in missing:
            progress.set_description(spec.parts[part].name)
            store.write(part, shard, make_shard(spec, part, shard))
            progress.update(spec.walks(part, shard))
    return store


def _description(folder: Path) -> dict[str, Any]:
    """The specification in the manifest of a store, as `DataSpec.to_dict` describes it."""
    try:
        manifest = json.loads((folder / "store.json").read_text(encoding="utf-8"))
        found, described = manifest["format_version"], manifest["spec"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError(
            f"'{folder}' is not a data store of Urushi; give the folder of `urushi data`"
        ) from error
    if found != FORMAT_VERSION:
        raise FileError(
            f"'{folder}' has data format {found}, and this Urushi reads {FORMAT_VERSION}; "
            "generate the data again"
        )
    return described


def _difference(found: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """Name the first entry in which two described specifications differ."""
    for name in ("seed", "shard"):
        if found[name] != wanted[name]:
            return f"its {name} is {found[name]}, not {wanted[name]}"
    names = [[part["name"] for part in spec["parts"]] for spec in (found, wanted)]
    if names[0] != names[1]:
        return f"its parts are {', '.join(names[0])} instead of {', '.join(names[1])}"
    pairs = zip(found["parts"], wanted["parts"], strict=True)
    part = next(ours["name"] for ours, theirs in pairs if ours != theirs)
    return f"its part '{part}' has another specification"
