"""Error at equal time of networks and walk: `python -m benchmarks.quality.equal_time`.

A picture by `layered` with n samples per pixel has the mean squared error V / n, where V is the
variance of one sample. A picture by `neural_layered` has V' / n + b, where b is the square of its
networks' error. All are measured: variances and times of a sample from passes that alternate
between the methods, and b against a reference of many samples by `layered`, with the noise of both
pictures subtracted.

Every scene is measured in its own light, under one point light beside the camera, and under a
cloudless sky with the sun (Mitsuba's `sunsky`). A line of the table has

- the time and the variance of a sample, relative to the walk;
- the walk's mean squared error divided by the networks', at the times in which the walk takes 4,
  16, 64 and 256 samples per pixel; the aim is 10 at one of them;
- the same ratio for an exact, noise-free BSDF that costs what `principled` costs. The networks'
  BSDF is free of noise and nearly exact, so that its variance V' is what light, visibility and
  sampling by its lobes leave. With the time T of a sample by the walk, and T' of a sample with
  `principled` and as many textures in the place of every coat, the ratio is V T / (V' T') at all
  times. V' is the least of the measured networks. Better sampling would lower V';
- the number of the walk's samples above which the networks' error is mostly bias, and the number at
  which the walk becomes better.

Under small lights, single bright samples decide the mean variances: those of caustics, which path
tracing hardly finds. `--depth 2` leaves them out, and `--seconds` makes them more certain. The
median over pixels of V' / V is a column of its own, which these samples hardly change.

Times are CPU times of all threads, the least of some renders. The fixed cost of a render, which
records the code of every BSDF in memory, is measured by passes of one sample and subtracted.
Loading and compiling have their own column. With default sizes it takes an hour on two cores;
`--scenes demo --lights point --width 128 --spp 256 --seconds 4` takes a minute. The reference is
stored in `--folder`, and a stopped run resumes. `equal-time.png` there shows the measured errors
while samples accumulate, and the lines that the table predicts.
"""

import argparse
import contextlib
import gc
import time
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.machine import processor
from benchmarks.quality.converged import (
    PASS_SPP,
    REFERENCE,
    Picture,
    add_arguments,
    converged,
    load,
)
from benchmarks.scenes import LIGHTS, PRINCIPLED
from benchmarks.speed.render import PAPER

from urushi.core import error_metrics as metrics
from urushi.fan2022.kernels import separate_kernels
from urushi.platform import available_cores

#: Times at which errors are compared, in samples of the walk.
TIMES = (4, 16, 64, 256)
AIM = 10

#: Least number of passes of a method, and of samples per pixel of a pass.
PASSES, LEAST_SPP = 4, 2
#: A long render, by which methods are timed, has the samples of `LONG` passes. It has fewer if the
#: whole picture would need more than `LONG_SAMPLES` samples. Every method renders `LONG_TURNS`.
LONG, LONG_SAMPLES, LONG_TURNS = 8, 1 << 20, 4
#: A method is slow if `PASSES` full passes take more than `SLOW` times `--seconds`.
SLOW = 10

COLUMNS = (
    "scene",
    "light",
    "networks",
    "time of a sample",
    "its variance",
    "median of pixels",
    *(f"error at {count}" for count in TIMES),
    f"exact, at `{PRINCIPLED}`'s cost",
    "mostly bias from",
    "walk better from",
    "start",
    f"aim: {AIM}",
)


@dataclass(eq=False)
class Method:
    """A way to render a scene, and the passes rendered so far.

    Attributes:
        scene: the loaded scene.
        separate: whether it renders within `separate_kernels`.
        samples: per pixel of a pass.
        start: CPU time of loading and of the first render, which compiles [s].
        seconds, fixed: CPU time of each pass, and of one with one sample per pixel [s].
        long: CPU time of each long render [s]; none of slow methods.
        total, squares: sums over passes of the pictures (H, W, 3), and of their squares.
        errors: (samples per pixel, mean squared error) at powers of two of the passes.
    """

    scene: Any
    separate: bool
    samples: int
    start: float
    seconds: list[float]
    fixed: list[float]
    long: list[float]
    total: np.ndarray
    squares: np.ndarray
    errors: list[tuple[int, float]]

    @property
    def passes(self) -> int:
        return len(self.seconds)

    @property
    def second(self) -> float:
        """CPU time of one sample per pixel in a long render [s].

        By the least times, because other load only adds to them.
        """
        times, samples = (
            (self.long, self.long_samples) if self.long else (self.seconds, self.samples)
        )
        return max(min(times) - min(self.fixed), 1e-9) / (samples - 1)

    @property
    def long_samples(self) -> int:
        """Samples per pixel of a long render."""
        pixels = self.total.shape[0] * self.total.shape[1]
        return self.samples * max(1, min(LONG, LONG_SAMPLES // (pixels * self.samples)))

    @property
    def variances(self) -> np.ndarray:
        """Variance (H, W) of one sample per pixel, as a mean over channels."""
        mean = self.total / self.passes
        spread = (self.squares / self.passes - mean**2) * self.passes / (self.passes - 1)
        return spread.mean(axis=-1) * self.samples

    @property
    def variance(self) -> float:
        """Variance of one sample per pixel, as a mean over all pixels."""
        return float(self.variances.mean())

    def bias(self, reference: Picture) -> float:
        """Unbiased estimate of the mean squared error of endless samples; it may be negative."""
        noise = self.variance / (self.passes * self.samples) + reference.noise
        return metrics.mse(self.total / self.passes, reference.image) - noise


def rendered(scene: Any, separate: bool, spp: int, seed: int) -> tuple[np.ndarray, float]:
    """A picture (H, W, 3) and its CPU time [s]; separate: within `separate_kernels`."""
    begin = time.process_time()
    with separate_kernels() if separate else contextlib.nullcontext():
        image = np.array(mi.render(scene, spp=spp, seed=seed), dtype=np.float64)
    return image, time.process_time() - begin


def start(name: str, light: str, method: str, arguments: argparse.Namespace) -> Method:
    """Load a scene and render it, so that its kernels are compiled.

    A pass has `PASS_SPP` samples per pixel. That of a slow method has as many as keep `PASSES`
    passes within `SLOW` times `--seconds`, but `LEAST_SPP` at least.
    """
    begin = time.process_time()
    scene, _ = load(name, method, arguments, light)
    separate = method.startswith(PAPER)
    for spp in (1, LEAST_SPP):  # one sample per pixel has a kernel of its own
        shape = rendered(scene, separate, spp, 0)[0].shape
    compiled = time.process_time()
    of_least = rendered(scene, separate, LEAST_SPP, 0)[1]
    affordable = LEAST_SPP * SLOW * arguments.seconds / (PASSES * of_least)
    samples = int(min(max(affordable, LEAST_SPP), PASS_SPP))
    nothing = np.zeros(shape)
    return Method(
        scene, separate, samples, compiled - begin, [], [], [], nothing, nothing.copy(), []
    )


def sample(method: Method, seed: int, reference: Picture) -> None:
    """Add one pass; at powers of two, store the error of the mean over all passes."""
    for spp, times in ((1, method.fixed), (method.samples, method.seconds)):
        image, seconds = rendered(method.scene, method.separate, spp, seed)
        times.append(seconds)
    method.total += image
    method.squares += image**2
    if method.passes & (method.passes - 1) == 0:
        error = metrics.mse(method.total / method.passes, reference.image) - reference.noise
        method.errors.append((method.passes * method.samples, error))


def measure(
    name: str, light: str, arguments: argparse.Namespace
) -> tuple[dict[str, Method], Picture]:
    """All methods after alternating passes, so that other load affects all equally; and the truth.

    Each method takes about `--seconds` of CPU time. A slow one stops after `PASSES` passes. Methods
    with separate kernels are measured afterwards: their BSDFs would be compiled into the kernels of
    the others.
    """
    reference = converged(name, REFERENCE, arguments.spp, arguments, light)
    names = (REFERENCE, PRINCIPLED, *arguments.weights)
    methods = {of: start(name, light, of, arguments) for of in names if not of.startswith(PAPER)}
    quick = [method for method in methods.values() if method.samples == PASS_SPP]
    passes = spent = 0.0
    while passes < PASSES or spent < arguments.seconds * len(quick):
        for number, method in enumerate(methods.values()):
            if passes < PASSES or method in quick:
                sample(method, 1000 * (int(passes) + 1) + number, reference)
        passes += 1
        spent = sum(sum(method.seconds) for method in quick)
    for turn in range(LONG_TURNS):
        for method in quick:
            method.long.append(
                rendered(method.scene, method.separate, method.long_samples, turn)[1]
            )
    for of in names:
        if of not in methods:
            methods[of] = start(name, light, of, arguments)
            for index in range(PASSES):
                sample(methods[of], 1000 * (index + 1) + len(methods), reference)
            methods[of].scene = None
            gc.collect()
    return methods, reference


def row(
    walk: Method, network: Method, reference: Picture, ideal: tuple[float, float]
) -> tuple[str, ...]:
    """The cells of a line after the names; ideal: time and variance of the noise-free BSDF."""
    time_ratio, variance_ratio = network.second / walk.second, network.variance / walk.variance
    bias = max(network.bias(reference), 0.0)
    ratios = [
        walk.variance / count / (network.variance * time_ratio / count + bias) for count in TIMES
    ]
    lit = walk.variances > 0
    limits = (network.variance * time_ratio, walk.variance - network.variance * time_ratio)
    return (
        f"{time_ratio:.2f}",
        f"{variance_ratio:.3f}",
        f"{np.median(network.variances[lit] / walk.variances[lit]):.3f}",
        *(f"{ratio:.2f}" for ratio in ratios),
        f"{walk.second * walk.variance / (ideal[0] * ideal[1]):.2f}",
        *(f"{max(limit / bias, 0):.0f}" if bias else "never" for limit in limits),
        f"{network.start:.0f} s",
        "ok" if max(ratios) >= AIM else "missed",
    )


def plot(measured: dict[str, dict[str, Method]], references: dict[str, Picture], path) -> None:
    """Draw errors over time by scene and light: measured points, lines by variance and bias."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(
        1, len(measured), figsize=(4.2 * len(measured), 3.8), squeeze=False, layout="constrained"
    )
    for axes, (title, methods) in zip(panels[0], measured.items(), strict=True):
        counts = np.geomspace(1, 4096, 60)
        for colour, (method, of) in enumerate(methods.items()):
            if method == PRINCIPLED:  # another material
                continue
            bias = 0.0 if method == REFERENCE else max(of.bias(references[title]), 0.0)
            label = method if method == REFERENCE else f"neural_layered, {method}"
            times = of.second * counts
            axes.loglog(times, of.variance / counts + bias, color=f"C{colour}", label=label)
            points = np.array([(n, error) for n, error in of.errors if error > 0])
            if len(points):
                axes.loglog(of.second * points[:, 0], points[:, 1], "o", color=f"C{colour}", ms=4)
        axes.set(title=title, xlabel="CPU time [s]")
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
    parser.add_argument("--lights", nargs="+", default=LIGHTS, choices=LIGHTS, help="lights")
    parser.add_argument("--spp", type=int, default=1024, help="samples per pixel of the reference")
    parser.add_argument("--seconds", type=float, default=20.0, help="CPU time of each method [s]")
    arguments = parser.parse_args()
    mi.set_variant(arguments.mode)
    print(f"{processor()}, {available_cores()} cores, {arguments.width} pixels wide\n")
    print(f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|", flush=True)
    measured: dict[str, dict[str, Method]] = {}
    references: dict[str, Picture] = {}
    notes = []
    for name, light in ((name, light) for name in arguments.scenes for light in arguments.lights):
        methods, reference = measure(name, light, arguments)
        measured[f"{name}, {light}"], references[f"{name}, {light}"] = methods, reference
        walk, least = methods[REFERENCE], min(methods[of].variance for of in arguments.weights)
        ideal = methods[PRINCIPLED].second, least
        for networks in arguments.weights:
            cells = row(walk, methods[networks], reference, ideal)
            print(f"| {' | '.join((name, light, networks, *cells))} |", flush=True)
        notes.append(
            f"- {name}, {light}: a sample of the walk takes {walk.second:.3g} s of CPU and has a "
            f"variance of {walk.variance:.3g}; with `{PRINCIPLED}` it takes {ideal[0]:.3g} s. The "
            f"reference's own variance is {reference.noise:.2g}; {walk.passes} passes."
        )
    print("", *notes, sep="\n")
    path = arguments.folder / "equal-time.png"
    plot(measured, references, path)
    print(f"\n{path}")


if __name__ == "__main__":
    main()
