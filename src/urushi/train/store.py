"""The store of simulated BRDF values, a zarr v3 group that describes itself; and its simulation.

Layout: every part of the specification is one group of arrays, whose first axis is the stack:

    coats   (S, N, C)  the coats' `checks.COAT_COLUMNS`, top to bottom (none if N = 0)
    bottom  (S, K)     the bottom's parameters, named by the array's attribute `names`
    wi, wo  (S, P, 3)  unit direction pairs, float32
    f, se   (S, P)     BRDF value [1/sr] and its standard error

One chunk is one shard. The shard's entry of `complete` is written last. If the writer is killed,
the store still holds whole shards and can be resumed. The group's attribute `urushi_data` is the
manifest.
"""

import contextlib
import hashlib
import json
import os
import platform
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from tqdm import tqdm

from urushi.checks import COAT_COLUMNS, CoatParameters
from urushi.core import direction_sets
from urushi.errors import FileError
from urushi.files import new_folder
from urushi.train.spec import DataSpec, Part
from urushi.version import __version__
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS
from urushi.walk.simulate import walk_pairs

FORMAT_VERSION = 1
_MANIFEST = "urushi_data"

#: A shard: the arrays of the layout above for its stacks.
Shard = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Store:
    """A data store on disk.

    Attributes:
        path: the store's folder.
        spec: the content of the complete store.
    """

    path: Path
    spec: DataSpec

    @classmethod
    def create(cls, path: str | os.PathLike, spec: DataSpec) -> "Store":
        """Make an empty store, or open an existing one of the same specification to resume it."""
        folder = Path(path)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            found, wanted = _description(folder), json.loads(json.dumps(spec.to_dict()))
            if found != wanted:
                raise FileError(
                    f"'{folder}' contains data of another specification "
                    f"({_difference(found, wanted)}); choose another path or delete that folder"
                )
            for stray in folder.rglob("*.partial"):  # left by a writer that was killed
                stray.unlink()
            return cls(folder, spec)
        new_folder(folder)
        with _readable(folder):
            root = zarr.create_group(folder, zarr_format=3)
            for part in spec.parts:
                _create_part(root, spec, part)
            # Last: a store that has a manifest has all its arrays.
            root.attrs[_MANIFEST] = {
                "format_version": FORMAT_VERSION,
                "spec": spec.to_dict(),
                "versions": versions(),
            }
        return cls(folder, spec)

    def missing(self) -> list[tuple[int, int]]:
        """The (part, shard) indices that are not yet complete, in order."""
        with _readable(self.path):
            root = zarr.open_group(self.path, mode="r")
            complete = [_array(root, part, "complete")[:] for part in self.spec.parts]
        return [(part, shard) for part, shard in self.spec.shards() if not complete[part][shard]]

    def write(self, part: int, shard: int, arrays: Shard) -> None:
        """Write one shard and then mark it complete."""
        with _readable(self.path):
            group = zarr.open_group(self.path, mode="r+")
            rows = self.spec.rows(part, shard)
            for name, values in arrays.items():
                _array(group, self.spec.parts[part], name)[rows] = values
            _array(group, self.spec.parts[part], "complete")[shard] = 1

    def read(
        self, part: Part, rows: slice | None = None, names: Collection[str] | None = None
    ) -> dict[str, np.ndarray]:
        """Read arrays of a part into memory.

        rows: consecutive ones that are complete; None: all. names: of the arrays; None: all.
        """
        rows = rows or slice(0, part.stacks)
        wanted = [name for name in _layout(part) if names is None or name in names]
        shards = slice(rows.start // self.spec.shard, -(-rows.stop // self.spec.shard))
        with _readable(self.path):
            root = zarr.open_group(self.path, mode="r")
            complete = _array(root, part, "complete")
            if not np.all(complete[shards]):
                raise FileError(
                    f"'{self.path}' is incomplete: part '{part.name}' has "
                    f"{int(np.sum(complete[:]))} of {self.spec.shard_count(part)} shards; "
                    "resume it with `urushi data`"
                )
            arrays = {name: _array(root, part, name)[rows] for name in wanted}
        if not all(np.isfinite(values).all() for values in arrays.values()):
            raise FileError(
                f"'{self.path}' is damaged: part '{part.name}' has values that are not finite; "
                "delete the folder and generate the data again"
            )
        return arrays

    def read_shard(
        self, part: int, shard: int, names: Collection[str] | None = None
    ) -> dict[str, np.ndarray]:
        """`read` for the rows of a shard."""
        return self.read(self.spec.parts[part], self.spec.rows(part, shard), names)

    def hash(self) -> str:
        """SHA-256 over the specification and all values f, recorded in the weights' header."""
        digest = hashlib.sha256(json.dumps(self.spec.to_dict(), sort_keys=True).encode())
        for part, shard in self.spec.shards():
            f = self.read_shard(part, shard, ("f",))["f"]
            digest.update(np.ascontiguousarray(f).tobytes())
        return digest.hexdigest()


def make_shard(spec: DataSpec, part: int, shard: int) -> Shard:
    """Draw and simulate the stacks of one shard.

    Args:
        spec: the whole specification.
        part, shard: indices of the part and of its shard.

    Returns:
        The arrays of `store`'s layout; they depend only on the arguments.
    """
    described = spec.parts[part]
    rows = spec.rows(part, shard)
    count = rows.stop - rows.start
    parameters, directions, walks = spec.seeds(part, shard).spawn(3)
    table = described.distribution.draw(np.random.default_rng(parameters), rows)
    rng = np.random.default_rng(directions)
    wi, wo = direction_sets.draw_pairs(described.directions, rng, count, described.pairs)
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

    The bytes of the result do not depend on interruptions.

    Args:
        spec: the content.
        path: the store's folder; only this process writes to it.
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


_ZARR_ERRORS = (OSError, ValueError, KeyError, TypeError, RuntimeError)


def _description(folder: Path) -> dict[str, Any]:
    """The specification in the manifest of a store, as `DataSpec.to_dict` describes it."""
    try:
        manifest: Any = zarr.open_group(folder, mode="r").attrs[_MANIFEST]
        found, described = manifest["format_version"], manifest["spec"]
    except _ZARR_ERRORS as error:
        raise FileError(
            f"'{folder}' is not a data store of Urushi; give the folder of `urushi data`"
        ) from error
    if found != FORMAT_VERSION:
        raise FileError(
            f"'{folder}' has data format {found}, and this Urushi reads {FORMAT_VERSION}; "
            "generate the data again"
        )
    return described


@contextlib.contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Turn zarr's errors about a damaged or unwritable store into a `FileError`."""
    try:
        yield
    except FileError:
        raise
    except _ZARR_ERRORS as error:
        raise FileError(
            f"'{path}' cannot be used ({type(error).__name__}: {error}); if it is damaged, delete "
            "the folder and generate the data again"
        ) from error


def _layout(part: Part) -> dict[str, tuple[int, ...]]:
    """Shapes of a part's arrays for one stack."""
    layout = {
        "coats": (part.distribution.coats, len(COAT_COLUMNS[part.distribution.widths])),
        "bottom": (len(KINDS[part.distribution.bottom].parameters),),
        "wi": (part.pairs, 3),
        "wo": (part.pairs, 3),
        "f": (part.pairs,),
        "se": (part.pairs,),
    }
    if part.distribution.coats == 0:
        del layout["coats"]
    return layout


def _create_part(root: zarr.Group, spec: DataSpec, part: Part) -> None:
    group = root.create_group(part.name)
    names = {
        "coats": COAT_COLUMNS[part.distribution.widths],
        "bottom": KINDS[part.distribution.bottom].parameters,
    }
    for name, shape in _layout(part).items():
        array = group.create_array(
            name,
            shape=(part.stacks, *shape),
            chunks=(min(spec.shard, part.stacks), *shape),
            dtype="float32",
        )
        if name in names:
            array.attrs["names"] = list(names[name])
    group.create_array("complete", shape=(spec.shard_count(part),), chunks=(1,), dtype="uint8")


def _array(root: zarr.Group, part: Part, name: str) -> Any:
    return root[f"{part.name}/{name}"]


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


def versions() -> dict[str, str]:
    """Versions of the software that values and files depend on, by name."""
    packages = {name: version(name) for name in ("numpy", "drjit", "zarr")}
    return {"urushi": __version__, "python": platform.python_version(), **packages}
