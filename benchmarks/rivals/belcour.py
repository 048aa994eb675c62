"""E of the statistical operators of Belcour 2018 against the stored reference.

    python benchmarks/rivals/belcour.py

Every group of stacks with coats over a bottom that the model describes; E as in docs/evaluation.md.
The two-layer stacks of Table 2 are also split by their scattering depth, the sum of albedo times
sigma_t over the media.
"""

import itertools

import numpy as np
from benchmarks.evaluation import benchmark
from benchmarks.evaluation.samples import Samples, stack_errors
from research.rivals import belcour

DESCRIBED = ("conductor", "conductor_complex", "dielectric", "diffuse")
#: The group that is split by scattering depth, and the limits of its parts.
SPLIT, DEPTHS = "two, table2", (0, 0.1, 1, np.inf)


def errors(samples: Samples) -> np.ndarray:
    """E of each stack, (S,)."""
    row = np.repeat(np.arange(len(samples.table), dtype=np.uint32), samples.wi.shape[1])
    f = belcour.rows(samples.table, row, samples.wi.reshape(-1, 3), samples.wo.reshape(-1, 3))
    return stack_errors(f.reshape(samples.f.shape), samples)


def print_row(name: str, e: np.ndarray) -> None:
    """Print one row of the table; e is in percent."""
    figures = " | ".join(f"{x:.1f} %" for x in (e.mean(), np.median(e), np.percentile(e, 95)))
    print(f"| {name} | {len(e)} | {figures} |")


def main() -> None:
    print("| stacks | number | E mean | median | 95th percentile |\n|---|---|---|---|---|")
    for name, samples in benchmark.read().items():
        if not samples.table.coats or samples.table.kind not in DESCRIBED:
            continue
        e = 100 * errors(samples)
        print_row(name, e)
        if name == SPLIT:
            depth = (samples.table.albedo * samples.table.sigma_t).sum(axis=1)
            for low, high in itertools.pairwise(DEPTHS):
                within = (depth >= low) & (depth < high)
                print_row(f"{name}, scattering depth {low:g} to {high:g}", e[within])


if __name__ == "__main__":
    main()
