"""E of the statistical operators of Belcour 2018 against the stored reference.

    python benchmarks/rivals/belcour.py

Every group of stacks with coats over a bottom that the model describes; E as in docs/evaluation.md.
"""

import numpy as np

from urushi.eval import benchmark
from urushi.eval.samples import Samples, stack_errors
from urushi.rivals import belcour

DESCRIBED = ("conductor", "conductor_complex", "dielectric", "diffuse")


def errors(samples: Samples) -> np.ndarray:
    """E of each stack, (S,)."""
    row = np.repeat(np.arange(len(samples.table), dtype=np.uint32), samples.wi.shape[1])
    f = belcour.rows(samples.table, row, samples.wi.reshape(-1, 3), samples.wo.reshape(-1, 3))
    return stack_errors(f.reshape(samples.f.shape), samples)


def main() -> None:
    print("| stacks | number | E mean | median | 95th percentile |\n|---|---|---|---|---|")
    for name, samples in benchmark.read().items():
        if not samples.table.coats or samples.table.kind not in DESCRIBED:
            continue
        e = 100 * errors(samples)
        figures = " | ".join(f"{x:.1f} %" for x in (e.mean(), np.median(e), np.percentile(e, 95)))
        print(f"| {name} | {len(e)} | {figures} |")


if __name__ == "__main__":
    main()
