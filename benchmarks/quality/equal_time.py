"""Error at equal time, networks against the walk: `python -m benchmarks.quality.equal_time`.

A picture of n samples a pixel by `layered` has the mean squared error V / n, V being the variance
of one sample; one by `neural_layered` has V' / n + b, b being the square of what its networks are
wrong by. All are measured: V and the time of a sample from passes that alternate between the
methods, b against a reference of many samples by `layered`, both pictures' own noise taken off.

The table says, for each scene and networks: the time of a sample over that of the walk, and its
variance over the walk's; the walk's mean squared error over the networks' at the time that the walk
takes for 4, 16, 64 and 256 samples a pixel; from how many of the walk's samples on the networks'
error is mostly bias; and where the walk overtakes. The aim is 10 at some time. Times are CPU times
of all threads, without loading and compiling, which is printed apart.

With default sizes it takes some twenty minutes on two cores. Pictures much smaller would tell a
path tracer's fixed costs, about 0.06 s a pass, more than the methods'. The reference is kept in
`--folder`; what was stopped resumes. `equal-time.png` there shows the errors as they were measured
while samples added up, and the lines that follow from the table.
"""

import argparse
import time
from dataclasses import dataclass
from statistics import median
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality.converged import (
    PASS_SPP,
    REFERENCE,
    Picture,
    add_arguments,
    converged,
    load,
)

from urushi.eval import metrics

#: Times at which errors are compared, in samples of the walk.
TIMES = (4, 16, 64, 256)
AIM = 10


@dataclass
class Method:
    """A way to render a scene: its passes' times [s of CPU] and pictures, as far as they went."""

    scene: Any
    start: float
    seconds: list[float]
    total: np.ndarray
    squares: np.ndarray
    errors: list[tuple[int, float]]

    @property
    def passes(self) -> int:
        return len(self.seconds)

    @property
    def second(self) -> float:
        """CPU seconds of one sample a pixel."""
        return median(self.seconds) / PASS_SPP

    @property
    def variance(self) -> float:
        """Of one sample a pixel, the mean over all pixels."""
        mean = self.total / self.passes
        spread = (self.squares / self.passes - mean**2) * self.passes / (self.passes - 1)
        return float(spread.mean()) * PASS_SPP

    def bias(self, reference: Picture) -> float:
        """Mean squared error for endless samples, an unbiased estimate: it may fall below zero."""
        noise = self.variance / (self.passes * PASS_SPP) + reference.noise
        return metrics.mse(self.total / self.passes, reference.image) - noise


def start(name: str, method: str, arguments: argparse.Namespace) -> Method:
    """Load a scene and render it once, which compiles."""
    begin = time.process_time()
    scene, _ = load(name, method, arguments)
    shape = np.array(mi.render(scene, spp=PASS_SPP, seed=0)).shape
    spent = time.process_time() - begin
    return Method(scene, spent, [], np.zeros(shape), np.zeros(shape), [])


def sample(method: Method, seed: int, reference: Picture) -> None:
    """Add one pass; at powers of two, note the error of all passes together."""
    begin = time.process_time()
    image = np.array(mi.render(method.scene, spp=PASS_SPP, seed=seed), dtype=np.float64)
    method.seconds.append(time.process_time() - begin)
    method.total += image
    method.squares += image**2
    if method.passes & (method.passes - 1) == 0:
        error = metrics.mse(method.total / method.passes, reference.image) - reference.noise
        method.errors.append((method.passes * PASS_SPP, error))


def row(walk: Method, network: Method, reference: Picture) -> str:
    """One line of the table."""
    slower, calmer = network.second / walk.second, network.variance / walk.variance
    bias = max(network.bias(reference), 0.0)
    ratios = [walk.variance / count / (network.variance * slower / count + bias) for count in TIMES]
    limits = (network.variance * slower, walk.variance - network.variance * slower)
    biased, overtaken = (f"{limit / bias:8.0f}" if bias else "   never" for limit in limits)
    verdict = "ok" if max(ratios) >= AIM else "MISSED"
    numbers = " ".join(f"{ratio:7.2f}" for ratio in ratios) + f" {biased} {overtaken}"
    return f"{slower:8.2f} {calmer:8.3f} {numbers} {network.start:7.0f} s {verdict}"


def plot(measured: dict[str, dict[str, Method]], references: dict[str, Picture], path) -> None:
    """Errors against time for every scene: points as measured, lines by variance and bias."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(
        1, len(measured), figsize=(4.2 * len(measured), 3.8), squeeze=False, layout="constrained"
    )
    for axes, (name, methods) in zip(panels[0], measured.items(), strict=True):
        counts = np.geomspace(1, 4096, 60)
        for colour, (method, of) in enumerate(methods.items()):
            bias = 0.0 if method == REFERENCE else max(of.bias(references[name]), 0.0)
            label = method if method == REFERENCE else f"neural_layered, {method}"
            times = of.second * counts
            axes.loglog(times, of.variance / counts + bias, color=f"C{colour}", label=label)
            points = np.array([(n, error) for n, error in of.errors if error > 0])
            if len(points):
                axes.loglog(of.second * points[:, 0], points[:, 1], "o", color=f"C{colour}", ms=4)
        axes.set(title=name, xlabel="CPU time [s]")
    panels[0][0].set_ylabel("mean squared error")
    panels[0][0].legend(frameon=False, fontsize="small")
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main() -> None:
    """Print the table and draw the plot."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.equal_time", description=__doc__
    )
    add_arguments(parser)
    parser.add_argument("--spp", type=int, default=1024, help="samples a pixel of the reference")
    parser.add_argument("--passes", type=int, default=16, help="passes a method")
    arguments = parser.parse_args()
    mi.set_variant(arguments.mode)
    print(
        f"{'scene':12} {'networks':8} {'time':>8} {'variance':>8} "
        + " ".join(f"{'at ' + str(count):>7}" for count in TIMES)
        + f" {'biased':>8} {'overtak.':>8} {'start':>9}  aim: >= {AIM}"
    )
    measured: dict[str, dict[str, Method]] = {}
    references: dict[str, Picture] = {}
    for name in arguments.scenes:
        reference = references[name] = converged(name, REFERENCE, arguments.spp, arguments)
        methods = measured[name] = {
            method: start(name, method, arguments) for method in (REFERENCE, *arguments.weights)
        }
        for index in range(arguments.passes):  # in turns, so that other load meets all alike
            for number, method in enumerate(methods.values()):
                sample(method, 1000 * (index + 1) + number, reference)
        walk = methods[REFERENCE]
        for networks in arguments.weights:
            line = row(walk, methods[networks], reference)
            print(f"{name:12} {networks:8} {line}", flush=True)
        print(
            f"{name:12} {REFERENCE:8} {walk.second:.3g} s of CPU and a variance of "
            f"{walk.variance:.3g} a sample, {walk.start:.0f} s to start; the reference's variance "
            f"is {reference.noise:.2g}",
            flush=True,
        )
    path = arguments.folder / "equal-time.png"
    plot(measured, references, path)
    print(path)


if __name__ == "__main__":
    main()
