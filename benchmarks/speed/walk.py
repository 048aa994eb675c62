"""Speed of the random walk: `python -m benchmarks.speed.walk`; under a minute on two cores.

Prints, for three stacks, millions of walks per second: the best and the median of several runs, and
the time of the first run, which compiles the kernel. A walk is one estimate of f for one pair of
directions and one channel. With `--lossless`, the stacks are lossless coats of several depths.
"""

import argparse
import time
from statistics import median

import numpy as np

from urushi.walk import Stack, coat, conductor, walk_pairs
from urushi.walk.table import from_stack

PAIRS, RUNS = 1024, 7
WALKS, LOSSLESS_WALKS = 2048, 128

STACKS = {
    "alpha 0.1, eta 1.5, albedo 0.9, sigma_t 1": coat(conductor(0.1, 0.9), 0.1, 1.5, 0.9, 1.0),
    "the same, albedo 0.99, sigma_t 8, g 0.5": coat(conductor(0.1, 0.9), 0.1, 1.5, 0.99, 8.0, 0.5),
    "three interfaces, sigma_t 0.5 and 1": coat(
        coat(conductor(0.2, 0.9), 0.3, 1.2, 0.9, 1.0), 0.1, 1.5, 0.9, 0.5
    ),
}

LOSSLESS = {
    f"lossless, sigma_t {depth:g}": coat(conductor(0.1, 0.9), 0.1, 1.5, 1.0, depth)
    for depth in (0, 2, 8, 20, 10_000)
}


def directions(count: int, seed: int) -> np.ndarray:
    """Cosine-distributed unit vectors (count, 3)."""
    u, v = np.random.default_rng(seed).random((2, count))
    r, phi = np.sqrt(u), 2 * np.pi * v
    w = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u)], axis=1)
    return w.astype(np.float32)


def seconds(stack: Stack, walks: int, seed: int) -> float:
    """The time of one run of PAIRS times `walks` walks."""
    table, row = from_stack(stack), np.zeros(PAIRS, np.uint32)
    wi, wo = directions(PAIRS, 1), directions(PAIRS, 2)
    start = time.perf_counter()
    walk_pairs(table, row, wi, wo, walks=walks, seed=seed)
    return time.perf_counter() - start


def main() -> None:
    """Print the table; runs of the stacks alternate, so that other load affects all equally."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.walk",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--runs", type=int, default=RUNS, help="number of runs of each stack")
    parser.add_argument("--lossless", action="store_true", help="lossless coats by their depth")
    options = parser.parse_args()
    stacks, walks = (LOSSLESS, LOSSLESS_WALKS) if options.lossless else (STACKS, WALKS)
    first = {name: seconds(stack, walks, 0) for name, stack in stacks.items()}
    times: dict[str, list[float]] = {name: [] for name in stacks}
    for run in range(1, options.runs + 1):
        for name, stack in stacks.items():
            times[name].append(seconds(stack, walks, run))
    millions = PAIRS * walks / 1e6
    print(f"{'million walks per second':44}{'best':>8}{'median':>8}{'first run':>11}")
    for name, runs in times.items():
        best, middle = millions / min(runs), millions / median(runs)
        print(f"{name:44}{best:8.2f}{middle:8.2f}{first[name]:10.1f}s")


if __name__ == "__main__":
    main()
