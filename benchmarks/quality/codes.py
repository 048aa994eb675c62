"""Errors of tables, codes and the layering network on held-out stacks, against the walk.

    python -m benchmarks.quality.codes FOLDER [--share 0.25] [--weights NAME]

FOLDER keeps the walks of the stacks, which take ten minutes on two cores, and a share of them less.
The stacks are practical ones of one to three coats and those of the whole domain of one, two and
four, over all kinds of bottoms, and coats of low index over metals, of a seed that no training data
have. Prints E in per cent: mean, median, 95th percentile and maximum. E of the walk's noise is
subtracted in squares.

table    tables by light transport, coat by coat
code     codes of the topmost coat by light transport at the probe pairs, over what `table` gives
network  codes by the layering network
"""

import argparse
from pathlib import Path

import numpy as np
from benchmarks.evaluation import predict
from benchmarks.evaluation.samples import Samples

from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.fan2022.store import DataSpec, Part, Store, generate
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.train.distribution import Extended, Practical
from urushi.walk import StackTable
from urushi.walk.bottoms import KINDS

#: Kinds of bottoms, and numbers of their stacks by number of coats.
BOTTOMS = ("conductor", "conductor_complex", "dielectric", "diffuse", "mixture", "measured_like")
PRACTICAL = dict.fromkeys((1, 2, 3), (24, 16, 6, 14, 16, 8))
WHOLE = dict.fromkeys((1, 2, 4), (16, 12, 8, 14, 16, 8))
LOW = {1: (12, 12, 0, 0, 0, 0)}

#: Pairs of a stack, walks of a pair, and the seed of both.
PAIRS, WALKS, SEED = 256, 2048, 777

WAYS = ("table", "code", "network")


def stacks(share: float = 1.0) -> DataSpec:
    """The held-out stacks, or a share of each kind, at pairs of cosine density."""
    parts = []
    for name, counts in (("practical", PRACTICAL), ("whole", WHOLE), ("low", LOW)):
        for coats, numbers in counts.items():
            for kind, count in zip(BOTTOMS, numbers, strict=True):
                drawn = Extended(coats, kind, indices=name if name != "practical" else "whole")
                drawn = Practical(coats, kind) if name == "practical" else drawn
                if count:
                    size = max(1, round(share * count))
                    title = f"{name}-{kind}-{coats}"
                    parts.append(Part(title, drawn, size, PAIRS, WALKS, "cosine"))
    return DataSpec(tuple(parts), seed=SEED, shard=64)


def errors(model: Model, store: Store) -> dict[str, dict[str, np.ndarray]]:
    """E (S,) of each of `WAYS` by class: distribution and number of coats, and those over metals.

    "over KIND" are all stacks over a kind of bottom.
    """
    found: dict[str, dict[str, list[np.ndarray]]] = {}
    for part in store.spec.parts:
        samples = held_out(part, store)
        name, kind, coats = part.name.split("-")
        names = [f"{name}, {coats}", f"over {kind}"]
        names += [f"{name}, {coats}, metal"] if kind.startswith("conductor") else []
        for way in WAYS:
            materials = predict.materials(model, samples, how=way)
            values = predict.evaluate(materials, samples.wi, samples.wo)
            own = without_noise(values, samples)
            for each in names:
                found.setdefault(each, {}).setdefault(way, []).append(own)
    return {
        name: {way: np.concatenate(parts) for way, parts in ways.items()}
        for name, ways in found.items()
    }


def held_out(part: Part, store: Store) -> Samples:
    """The stacks of a part with the walk's values."""
    arrays = store.read(part)
    kind = part.distribution.bottom
    coats = CoatParameters.of_columns(np.moveaxis(arrays["coats"], -1, 0))
    bottom = dict(zip(KINDS[kind].parameters, arrays["bottom"].T, strict=True))
    table = StackTable(**coats._asdict(), kind=kind, bottom=bottom)
    return Samples(table, *(arrays[name] for name in ("wi", "wo", "f", "se")))


def without_noise(values: np.ndarray, samples: Samples) -> np.ndarray:
    """E (S,) of values (S, M), less that of the walk's noise in squares."""
    cosines = samples.wi[..., 2], samples.wo[..., 2]
    noisy = samples.f + samples.se * np.sqrt(2 / np.pi)  # the mean size of a normal error
    e, noise = (error_metrics.stack_error(f, samples.f, *cosines) for f in (values, noisy))
    return np.sqrt(np.maximum(e**2 - noise**2, 0))


def summary(e: np.ndarray) -> list[float]:
    """Mean, median, 95th percentile and maximum."""
    return [e.mean(), *np.percentile(e, [50, 95]), e.max()]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.codes",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, help="of the walks, which later runs read")
    parser.add_argument("--share", type=float, default=1.0, help="of the stacks")
    parser.add_argument("--weights", help="a name or file; default: the default ones")
    options = parser.parse_args()
    model = weights.find(options.weights)
    store = generate(stacks(options.share), options.folder)
    print(f"weights {model.fingerprint}; E [%]: mean, median, p95, max")
    print(f"{'':28}{'stacks':>7}" + "".join(f"{way:>28}" for way in WAYS))
    for name, ways in errors(model, store).items():
        cells = ["".join(f"{100 * x:7.2f}" for x in summary(ways[way])) for way in WAYS]
        print(f"{name:28}{len(ways['code']):7}" + "".join(cells), flush=True)


if __name__ == "__main__":
    main()
