"""Error at equal time of networks and walk: `python -m benchmarks.quality.equal_time`.

A picture by `layered` with n samples per pixel has the mean squared error V / n, where V is the
variance of one sample. A picture by `neural_layered` has V' / n + b, where b is the square of its
networks' error. All are measured: variances and times of a sample from passes that alternate
between the methods, and b against a reference of many samples by `layered`, with the noise of both
pictures subtracted.

For each scene and networks, the table has

- the time and the variance of a sample, relative to the walk;
- the walk's mean squared error divided by the networks', at the times in which the walk takes 4,
  16, 64 and 256 samples per pixel; the aim is 10 at one of them;
- the number of the walk's samples above which the networks' error is mostly bias, and the number at
  which the walk becomes better.

Times are CPU times of all threads; loading and compiling are printed separately. With default sizes
it takes twenty minutes on two cores. In much smaller pictures the fixed cost of a pass, about
0.06 s, would hide the difference between methods. The reference is stored in `--folder`, and a
stopped run resumes. `equal-time.png` there shows the measured errors while samples accumulate, and
the lines that the table predicts.
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
    """A way to render a scene, and the passes rendered so far.

    Attributes:
        scene: the loaded scene.
        start: CPU time of loading and of the first render, which compiles [s].
        seconds: CPU time of each pass [s].
        total, squares: sums over passes of the pictures (H, W, 3), and of their squares.
        errors: (samples per pixel, mean squared error) at powers of two of the passes.
    """

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
        """CPU time of one sample per pixel [s]."""
        return median(self.seconds) / PASS_SPP

    @property
    def variance(self) -> float:
        """Variance of one sample per pixel, as a mean over all pixels."""
        mean = self.total / self.passes
        spread = (self.squares / self.passes - mean**2) * self.passes / (self.passes - 1)
        return float(spread.mean()) * PASS_SPP

    def bias(self, reference: Picture) -> float:
        """Unbiased estimate of the mean squared error of endless samples; it may be negative."""
        noise = self.variance / (self.passes * PASS_SPP) + reference.noise
        return metrics.mse(self.total / self.passes, reference.image) - noise


def start(name: str, method: str, arguments: argparse.Namespace) -> Method:
    """Load a scene and render it once, so that its kernels are compiled."""
    begin = time.process_time()
    scene, _ = load(name, method, arguments)
    shape = np.array(mi.render(scene, spp=PASS_SPP, seed=0)).shape
    spent = time.process_time() - begin
    return Method(scene, spent, [], np.zeros(shape), np.zeros(shape), [])


def sample(method: Method, seed: int, reference: Picture) -> None:
    """Add one pass; at powers of two, store the error of the mean over all passes."""
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
    time_ratio, variance_ratio = network.second / walk.second, network.variance / walk.variance
    bias = max(network.bias(reference), 0.0)
    ratios = [
        walk.variance / count / (network.variance * time_ratio / count + bias) for count in TIMES
    ]
    limits = (network.variance * time_ratio, walk.variance - network.variance * time_ratio)
    biased, overtaken = (f"{limit / bias:8.0f}" if bias else "   never" for limit in limits)
    verdict = "ok" if max(ratios) >= AIM else "MISSED"
    numbers = " ".join(f"{ratio:7.2f}" for ratio in ratios) + f" {biased} {overtaken}"
    return f"{time_ratio:8.2f} {variance_ratio:8.3f} {numbers} {network.start:7.0f} s {verdict}"


def plot(measured: dict[str, dict[str, Method]], references: dict[str, Picture], path) -> None:
    """Draw errors over time for every scene: measured points, and lines by variance and bias."""
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
        prog="python -m benchmarks.quality.equal_time",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_arguments(parser)
    parser.add_argument("--spp", type=int, default=1024, help="samples per pixel of the reference")
    parser.add_argument("--passes", type=int, default=16, help="passes of each method")
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
        for index in range(arguments.passes):  # alternating, so that other load affects all equally
            for number, method in enumerate(methods.values()):
                sample(method, 1000 * (index + 1) + number, reference)
        walk = methods[REFERENCE]
        for networks in arguments.weights:
            line = row(walk, methods[networks], reference)
            print(f"{name:12} {networks:8} {line}", flush=True)
        print(
            f"{name:12} {REFERENCE:8} {walk.second:.3g} s of CPU and a variance of "
            f"{walk.variance:.3g} per sample, {walk.start:.0f} s to start, "
            f"reference variance {reference.noise:.2g}",
            flush=True,
        )
    path = arguments.folder / "equal-time.png"
    plot(measured, references, path)
    print(path)


if __name__ == "__main__":
    main()
