"""Variance times seconds of the bidirectional estimator beside the walk's.

    python -m benchmarks.quality.estimators

Prints a Markdown table. The variance is the mean of the squared relative errors over 32 pairs, and
the ratio is that of the walk over that of the bidirectional estimator: above 1, the latter is
better at equal time.
"""

import argparse
import time

import numpy as np
from research import bidirectional

import urushi

METAL, WHITE = urushi.conductor(alpha=0.3, r0=0.9), urushi.diffuse(0.7)


def layered(bottom, coats, **medium):
    """A bottom under equal coats, of indices 1.5 and 1.3 in turn."""
    for number in range(coats):
        bottom = urushi.coat(bottom, 0.15, 1.3 if number % 2 else 1.5, **medium)
    return bottom


CASES = {
    "clear coat on metal": layered(METAL, 1, albedo=1, sigma_t=0),
    "depth 1, g 0, on metal": layered(METAL, 1, albedo=0.95, sigma_t=1),
    "depth 1, g 0.9, on metal": layered(METAL, 1, albedo=0.95, sigma_t=1, g=0.9),
    "depth 4, g 0.9, on metal": layered(METAL, 1, albedo=0.95, sigma_t=4, g=0.9),
    "depth 4, g 0.95, on metal": layered(METAL, 1, albedo=0.95, sigma_t=4, g=0.95),
    "depth 16, g 0, on white": layered(WHITE, 1, albedo=0.99, sigma_t=16),
    "depth 16, g 0.9, on white": layered(WHITE, 1, albedo=0.99, sigma_t=16, g=0.9),
    "two coats, depth 1, g 0.9, on metal": layered(METAL, 2, albedo=0.95, sigma_t=1, g=0.9),
    "four coats, depth 0.5, g 0.5, on metal": layered(METAL, 4, albedo=0.95, sigma_t=0.5, g=0.5),
}


def main() -> None:
    """Measure all cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walks", type=int, default=1 << 15, help="walks per pair")
    options = parser.parse_args()
    print("| stack | variance | seconds | variance × seconds |\n|---|---|---|---|")
    wi, wo = directions(32)
    for name, stack in CASES.items():
        line(
            name,
            *(
                measure(stack, wi, wo, options.walks, e)
                for e in (urushi.simulate, bidirectional.simulate)
            ),
        )


def line(name: str, walk: tuple[float, float], both: tuple[float, float]) -> None:
    """Print a line of the table: ratios of two variances, of two times and of their products."""
    variance, seconds = (a / b for a, b in zip(walk, both, strict=True))
    print(f"| {name} | {variance:.2g} | {seconds:.2g} | {variance * seconds:.2g} |", flush=True)


def directions(count: int) -> np.ndarray:
    """Two arrays (count, 3) of unit vectors whose cosines are at least 0.2."""
    rng = np.random.default_rng(1)
    cosine, angle = rng.uniform(0.2, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    sine = np.sqrt(1 - cosine**2)
    return np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], axis=-1)


def measure(stack, wi, wo, walks, simulate) -> tuple[float, float]:
    """Mean squared relative standard error, and CPU seconds; the kernel is compiled before."""
    for count in (2, walks):
        start = time.process_time()
        f, se = simulate(stack, wi, wo, walks=count, seed=1)
    return float(np.mean((se / f) ** 2)), time.process_time() - start


if __name__ == "__main__":
    main()
