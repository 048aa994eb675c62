"""Speed of encoding and layering: `python -m benchmarks.speed.texture`; two minutes.

Prints the best and the median time of several runs, for one RGB material and for a texture of
1024 x 1024 RGB texels (`--side` sets another size). Runs of the operations alternate, so that other
load affects all equally. The texture's coats differ in all parameters by texel and by channel, over
a textured bottom; then the same over one bottom; then coats that are equal in all channels. At
1024 x 1024 it needs 1.5 GB of memory.
"""

import argparse
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from benchmarks.evaluation.report import parameters

from urushi.checks import CoatParameters
from urushi.material import encode, layer
from urushi.material.layer import layer_texels
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.walk import conductor, dielectric

GOLD, TOP = conductor(0.2, (0.98, 0.77, 0.34)), dielectric(0.05, 1.5)


def single_operations(model: Model) -> dict[str, Callable[[], object]]:
    """Operations on one material, by name."""
    bottom = encode(GOLD, model)
    return {
        "encode one RGB material": lambda: encode(GOLD, model),
        "layer one RGB material": lambda: layer(TOP, bottom, albedo=0.8, sigma_t=(0.2, 1.0, 3.0)),
    }


def texture_operations(model: Model, side: int) -> dict[str, Callable[[], object]]:
    """Layering of side x side RGB texels, by name; coats vary in every parameter and channel."""
    rng = np.random.default_rng(0)
    shape = side, side, 3
    coat: dict[str, Any] = {
        "alpha": rng.uniform(0.05, 0.5, shape),
        "eta": rng.uniform(1.3, 1.7, shape),
        "albedo": rng.uniform(0, 1, shape),
        "sigma_t": rng.uniform(0, 3, shape),
        "g": rng.uniform(-0.5, 0.5, shape),
    }
    grey = {name: values[..., :1] for name, values in coat.items()}
    one = encode(GOLD, model).latents
    many = np.broadcast_to(one, (side, side, *one.shape)).copy()
    return {
        "all varying": lambda: layer_texels(model, many, CoatParameters(**coat)),
        "one bottom": lambda: layer_texels(model, one, CoatParameters(**coat)),
        "grey coat": lambda: layer_texels(model, many, CoatParameters(**grey)),
    }


def table(heading: str, operations: dict[str, Callable[[], object]], runs: int) -> None:
    """Print the times of some operations."""
    times: dict[str, list[float]] = {name: [] for name in operations}
    for _ in range(runs):
        for name, operation in operations.items():
            start = time.perf_counter()
            operation()
            times[name].append(time.perf_counter() - start)
    print(f"{heading:36}{'best':>12}{'median':>12}")
    for name, values in times.items():
        print(f"{name:36}{_duration(min(values))}{_duration(median(values))}")


def _duration(seconds: float) -> str:
    return f"{seconds:10.2f} s" if seconds >= 1 else f"{1000 * seconds:9.2f} ms"


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.texture",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("--side", type=int, default=1024, help="side of the texture [texels]")
    arguments = parser.parse_args()
    model = weights.find(arguments.weights)
    sizes = ", ".join(f"{part} {count:,}" for part, count in parameters(model).items())
    print(f"parameters: {sizes}\n")
    table("one RGB material", single_operations(model), 50)
    print()
    table(f"{arguments.side}² RGB texture", texture_operations(model, arguments.side), 3)


if __name__ == "__main__":
    main()
