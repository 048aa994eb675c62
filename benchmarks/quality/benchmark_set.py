"""The stored benchmark set: `python -m benchmarks.quality.benchmark_set FILE [--keep OLD]`.

Simulates the groups of stacks that `urushi eval` compares with, in about a quarter of an hour on
two idle cores. `--keep` copies the groups of an existing set instead of simulating them; the file
itself continues a run that was stopped.
"""

import argparse
import os
from pathlib import Path

from urushi.eval import samples as sampling
from urushi.eval.benchmark import SEED, checked_content, describe, read, write
from urushi.eval.groups import GROUPS, Group
from urushi.eval.samples import Samples


def make(
    path: str | os.PathLike,
    groups: tuple[Group, ...] = GROUPS,
    keep: str | os.PathLike | None = None,
) -> str:
    """Simulate groups and write them to a file; returns its hash.

    The file is written after each group, so that a stopped run continues with `keep=path`.

    Args:
        path: file to write; it may be `keep` itself.
        groups: to write.
        keep: a file of `write`. Groups that it holds with the same description and seed are taken
            from it, to the bit, and not simulated. Its other groups are left out.

    Raises:
        FileError: `keep` is missing, foreign or damaged, or the file cannot be written.
    """
    sets: dict[str, Samples] = {}
    if keep is not None:
        description, _ = checked_content(keep)
        held = {group["name"]: group for group in description["groups"]}
        same = [group for group in groups if held.get(group.name) == describe(group)]
        if description["seed"] == SEED:
            sets = read(keep, tuple(same))
    digest = write(path, sets, tuple(group for group in groups if group.name in sets))
    for group in groups:
        if group.name not in sets:
            sets[group.name] = sampling.simulate(group, SEED)
            digest = write(path, sets, tuple(group for group in groups if group.name in sets))
    return digest


def main() -> None:
    """Write the set."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.benchmark_set",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, help="file to write (.safetensors)")
    parser.add_argument("--keep", type=Path, help="an existing set, whose groups are copied")
    arguments = parser.parse_args()
    print(f"{arguments.file}  {make(arguments.file, keep=arguments.keep)}")


if __name__ == "__main__":
    main()
