"""Cost of data by size: `python -m benchmarks.speed.scaling data`, or `train`.

Takes about a minute each on two cores; the figures of docs/scaling.md come from here. Stores are
written to a temporary folder (TMPDIR) and take some hundred MB.

data     time, files and bytes of a shard in the sizes of the preset `quick`: simulate, write, read
train    samples per second and peak memory of training: from a store, and from one four times as
         large. Each in a process of its own
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from urushi.train.distribution import Extended, Table2
from urushi.train.store import DataSpec, Part, Store, generate, make_shard

#: Direction pairs per stack and walks per pair, as in `quick`, an earlier preset for experiments.
PAIRS, WALKS = 512, 32

#: Number of timed calls of the compiled loop, after one that compiles.
CALLS = 12


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


def train(folder: Path) -> None:
    """Run `measure` in a process of its own for each case."""
    for label, stacks in (("1.6 M pairs", 2048), ("6.3 M pairs", 8192)):
        store = generate(quick_like(stacks), folder / f"{stacks}").path
        arguments = json.dumps([str(store), stacks])
        run = [sys.executable, "-m", "benchmarks.speed.scaling", "train", "--measure", arguments]
        printed = subprocess.run(run, check=True, capture_output=True, text=True).stdout
        print(f"{label}: {printed.strip()}")


def measure(store: str, stacks: int) -> None:
    """Print speed and peak memory of the joint stage of `quick`."""
    from urushi.nets.architecture import Architecture
    from urushi.train import examples, training
    from urushi.train.optimiser import Schedule, compile_steps
    from urushi.train.presets import Preset
    from urushi.train.stages.joint import Joint

    joint = Joint(Schedule(steps=20_480, warmup=256, learning_rate=0.02), (36, 160, 44))
    arch = Architecture(latent=24, decoder=(24, 24), lobes=1, sampler=(16,))
    preset = Preset("quick", quick_like(stacks), (joint,), pairs=128, arch=arch)
    depths = examples.load(Store(Path(store), preset.data), preset.arch, preset.pairs)
    params = training.initial(preset, depths)
    task = joint.task(params, preset.architectures()[1], depths, preset.seed)
    take = compile_steps(task.loss, joint.schedule)
    state = training.begin(preset, 0, params).state
    steps, waiting = joint.schedule.steps_per_call, 0.0
    times = []
    for call in range(CALLS + 1):
        began = time.perf_counter()
        batches = task.batches(call * steps, steps)
        drawn = time.perf_counter()
        state, terms = take(state, batches)
        terms["loss"].block_until_ready()
        if call:
            times.append(time.perf_counter() - began)
            waiting += drawn - began
    samples = steps * sum(joint.stacks) * preset.pairs / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    print(
        f"best {samples / min(times):.2f}, mean {samples / np.mean(times):.2f} M samples/s; "
        f"{waiting / sum(times):.1%} of it waits for batches; peak {peak:.0f} MB"
    )


def main() -> None:
    """Run one of the parts."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.scaling",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parts = {"data": data, "train": train}
    parser.add_argument("part", choices=parts)
    parser.add_argument("--measure", help=argparse.SUPPRESS)  # of a process of its own
    arguments = parser.parse_args()
    if arguments.measure:
        measure(*json.loads(arguments.measure))
        return
    with tempfile.TemporaryDirectory() as temporary:
        parts[arguments.part](Path(temporary))


if __name__ == "__main__":
    main()
