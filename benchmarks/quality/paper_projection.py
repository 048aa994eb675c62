"""Projections of BRDFs into the paper's codes: `python -m benchmarks.quality.paper_projection W`.

Simulates stacks of one coat by Table 2 of Fan et al. (2022), projects them with the evaluation
network of a weights file, and prints for every projection, as means over the stacks:

- the mean absolute error of f [1/sr], and of the authors' compressed x / (1 + x), x = f cos, at
  stratified pairs that the projection has not seen;
- how well a code is repeated: the root mean square difference of codes from two draws of pairs,
  relative to the spread of codes over the stacks. No layering network can predict this part;
- the processor time for a code, with one thread of BLAS.

With the default options it takes some minutes of one core, each further hundred pairs five minutes.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
import threadpoolctl

from urushi.core.direction_sets import stratified_pairs
from urushi.fan2022 import PaperNetworks, projection
from urushi.fan2022.architecture import AdamProjection
from urushi.fan2022.inference import LIGHT_COSINE, direction_inputs, evaluate
from urushi.fan2022.preset import Palette
from urushi.walk import walk_pairs

#: Stratified pairs of each stack for its projection, and for its errors; walks for each.
PAIRS, TEST_PAIRS, WALKS, TEST_WALKS = 8**4, 7**4, 256, 1024

Project = Callable[[int], np.ndarray]


def simulated(stacks: int, pairs: int, walks: int, seed: int) -> tuple[np.ndarray, ...]:
    """Directions wi, wo (S, P, 3) and values f (S, P) [1/sr] of stacks that no training has."""
    table = Palette(1, seed=1000).draw(np.random.default_rng(0), slice(0, stacks))
    rng = np.random.default_rng(seed)
    drawn = [stratified_pairs(rng, pairs) for _ in range(stacks)]
    wi, wo = (np.concatenate([pair[side] for pair in drawn]) for side in (0, 1))
    row = np.repeat(np.arange(stacks, dtype=np.uint32), pairs)
    f, _ = walk_pairs(table, row, wi, wo, walks=walks, seed=seed)
    return *(w.reshape(stacks, pairs, 3) for w in (wi, wo)), f.reshape(stacks, pairs)


def projections(params, data: tuple[np.ndarray, ...], pairs: list[int]) -> dict[str, Project]:
    """Functions from a seed to codes (S, 32), by name."""
    wi, wo, f = data

    def of_pairs(count: int) -> Project:
        options, directions = AdamProjection(pairs=count), direction_inputs(wi, wo)
        return lambda seed: projection.project(params, directions, f, options, seed)[0]

    return {f"{n} pairs": of_pairs(n) for n in pairs}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("weights", help="weights file of the kind paper")
    parser.add_argument("--stacks", type=int, default=8)
    parser.add_argument(
        "--pairs", type=int, nargs="*", default=[16, 64], help="of a projection's steps"
    )
    options = parser.parse_args()
    model = PaperNetworks.read(options.weights)
    data = simulated(options.stacks, PAIRS, WALKS, 1)
    wi, wo, f = simulated(options.stacks, TEST_PAIRS, TEST_WALKS, 2)
    directions = direction_inputs(wi, wo)
    cos = directions[..., LIGHT_COSINE]
    print(f"weights {model.fingerprint}, {options.stacks} stacks")
    print(f"{'projection':<24}{'L1':>9}{'compressed':>12}{'repeated':>10}{'CPU s':>8}")

    def report(name: str, z: np.ndarray, repeated: float, seconds: float) -> None:
        value = np.maximum(evaluate(model.params, z[:, None], directions), 0)
        difference = projection.compressed(value * cos) - projection.compressed(f * cos)
        errors = np.abs(value - f).mean(), np.abs(difference).mean()
        print(f"{name:<24}{errors[0]:>9.4f}{errors[1]:>12.5f}{repeated:>10.3f}{seconds:>8.1f}")

    report("none: every code 1", np.ones((options.stacks, 32), np.float32), 0.0, 0.0)
    with threadpoolctl.threadpool_limits(1):
        for name, project in projections(model.params, data, options.pairs).items():
            began = time.process_time()
            first, second = project(0), project(1)
            seconds = (time.process_time() - began) / (2 * options.stacks)
            noise = np.sqrt(np.mean((first - second) ** 2) / 2)
            report(name, first, noise / np.sqrt(first.var(axis=0).mean()), seconds)


if __name__ == "__main__":
    main()
