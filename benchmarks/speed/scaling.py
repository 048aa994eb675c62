"""Cost of simulated data by size: `python -m benchmarks.speed.scaling`.

Takes about a minute on two cores; the figures of docs/scaling.md come from here: time, files and
bytes of a shard in the sizes of the preset `quick`, to simulate, write and read. Stores are written
to a temporary folder (TMPDIR) and take some hundred MB.
"""

import argparse
import tempfile
import time
from pathlib import Path

from urushi.train.distribution import Extended, Table2
from urushi.train.store import DataSpec, Part, Store, generate, make_shard

#: Direction pairs per stack and walks per pair, as in `quick`, an earlier preset for experiments.
PAIRS, WALKS = 512, 32


def quick_like(stacks: int) -> DataSpec:
    """Parts of no coat, one and two, in about the proportions of `quick`; two walks per pair."""
    parts = (
        Part("bare", Extended(0, "conductor"), stacks // 4, PAIRS, 1),
        Part("once", Table2(1), stacks, PAIRS, 2),
        Part("twice", Table2(2), stacks // 4, PAIRS, 2),
    )
    return DataSpec(parts, seed=1)


def data(folder: Path) -> None:
    """Print the cost of shards."""
    for coats in (0, 1, 2):
        spec = DataSpec((Part("a", Extended(coats, "conductor"), 512, PAIRS, WALKS),), seed=1)
        make_shard(spec, 0, 1)  # compiles the kernels
        began = time.perf_counter()
        made = make_shard(spec, 0, 0)
        simulated = time.perf_counter()
        store = Store.create(folder / f"{coats}", spec)
        before = set(store.path.rglob("*"))
        opened = time.perf_counter()
        store.write(0, 0, made)
        written = time.perf_counter()
        files = [x for x in set(store.path.rglob("*")) - before if x.is_file()]
        read_began = time.perf_counter()
        store.read_shard(0, 0)
        read = time.perf_counter()
        size = sum(file.stat().st_size for file in files)
        print(
            f"{coats} coats: a shard of 256 x {PAIRS} pairs, {WALKS} walks: "
            f"make {simulated - began:.2f} s ({spec.walks(0, 0) / (simulated - began) / 1e6:.1f} M "
            f"walks/s), write {written - opened:.3f} s, read {read - read_began:.3f} s, "
            f"{len(files)} files, {size / 2**20:.2f} MB on disk, "
            f"{sum(x.nbytes for x in made.values()) / 2**20:.2f} MB in memory"
        )
    whole = generate(quick_like(1024), folder / "whole")
    began = time.perf_counter()
    whole.hash()
    shards = len(list(whole.spec.shards()))
    print(f"hash: {(time.perf_counter() - began) / shards * 1e3:.1f} ms a shard")
    spec = DataSpec((Part("a", Table2(1), 4096, 4, 2),), seed=1, shard=1)
    store = Store.create(folder / "many", spec)
    (store.path / "a").mkdir()
    for shard in range(4096):
        (store.path / "a" / f"{shard:05}.safetensors").touch()
    began = time.perf_counter()
    store.missing()
    print(f"what is missing of 4,096 shards: {time.perf_counter() - began:.2f} s")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.scaling",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data(Path(folder))


if __name__ == "__main__":
    main()
