"""Pictures: their differences as a display shows them, and what they cost at equal time.

A picture by a walk with n samples per pixel has the mean squared error V / n, where V is the
variance of one sample; one by networks has V' / n + b, where b is the square of their error. All
are measured: variances and times of a sample from passes that alternate between the methods, and b
against a converged picture by `layered`, with the noise of both pictures subtracted.
"""

import contextlib
import gc
import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import flip_evaluator
import mitsuba as mi
import numpy as np
from benchmarks.experiment import kept
from benchmarks.scenes import PAPER, WALK, View
from fan2022.kernels import separate_kernels
from tqdm import tqdm

from urushi.core import error_metrics as metrics

#: PSNR of equal pictures [dB], finite so that means are finite. It is higher than that of any two
#: different pictures of 16 bits per channel.
BEST_PSNR = 100.0
#: Samples per pixel of one pass, which bounds the memory; least number of passes of a method, and
#: of samples of a pass.
PASS_SPP, PASSES, LEAST_SPP = 16, 4, 2
#: A long render, by which methods are timed, has the samples of `LONG` passes; see `at_equal_time`.
LONG, LONG_TURNS, SLOW = 8, 4, 10


def psnr(image: np.ndarray, reference: np.ndarray, mask: np.ndarray) -> float:
    """PSNR [dB] in sRGB of two pictures (H, W, 3) of linear radiance, at most `BEST_PSNR`.

    It is that of the pixels of a mask (H, W): a black background would make it better.
    """
    return min(metrics.psnr(*(metrics.shown(x)[mask] for x in (image, reference))), BEST_PSNR)


def flip(image: np.ndarray, reference: np.ndarray) -> float:
    """Mean FLIP (Andersson et al. 2020) of pictures (H, W, 3) of linear radiance in sRGB.

    There are 67 pixels per degree of the visual field.
    """
    pair = (np.ascontiguousarray(metrics.shown(x), np.float32) for x in (reference, image))
    return float(flip_evaluator.evaluate(*pair, "LDR", applyMagma=False)[0].mean())


@dataclass(frozen=True)
class Picture:
    """Means (H, W, 3) of two independent halves of the samples, linear radiance."""

    first: np.ndarray
    second: np.ndarray

    @property
    def image(self) -> np.ndarray:
        return (self.first + self.second) / 2

    @property
    def variance(self) -> np.ndarray:
        """The image's variance by pixel and channel, an unbiased estimate."""
        return metrics.halves_variance(self.first, self.second)


def converged(view: View, method: str, spp: int) -> Picture:
    """Render a scene with `spp` samples per pixel, or read the picture that is kept."""
    scene, key = view.load(method)
    passes = max(2, 2 * round(spp / PASS_SPP / 2))
    name = f"{view.name}-{Path(method).stem}-{passes}"

    def halves() -> list[np.ndarray]:
        sums: list[Any] = [0.0, 0.0]
        for index in tqdm(range(passes), desc=name, disable=None):
            # Methods have different seeds, so that two pictures share no noise.
            seed = int(hashlib.sha256(f"{method} {index}".encode()).hexdigest()[:8], 16)
            image = mi.render(scene, spp=PASS_SPP, seed=seed).numpy()
            sums[index % 2] = sums[index % 2] + image.astype(np.float64)
        return [total / (passes // 2) for total in sums]

    return Picture(*kept(f"pictures/{name}-{key[:16]}", halves))


@dataclass(eq=False)
class Method:
    """A way to render a scene, and the passes rendered so far.

    Attributes:
        scene: the loaded scene.
        separate: whether it renders within `separate_kernels`.
        samples: per pixel of a pass.
        seconds, fixed, long: CPU times of passes, of passes of one sample per pixel, and of long
            renders [s]; slow methods have no long ones.
        total, squares: sums over passes of the pictures (H, W, 3), and of their squares.
    """

    scene: Any
    separate: bool
    samples: int = PASS_SPP
    seconds: list[float] = field(default_factory=list)
    fixed: list[float] = field(default_factory=list)
    long: list[float] = field(default_factory=list)
    total: Any = 0.0
    squares: Any = 0.0

    def render(self, spp: int, seed: int) -> tuple[np.ndarray, float]:
        """A picture (H, W, 3) and its CPU time [s]."""
        begin = time.process_time()
        with separate_kernels() if self.separate else contextlib.nullcontext():
            image = np.array(mi.render(self.scene, spp=spp, seed=seed), dtype=np.float64)
        return image, time.process_time() - begin

    def sample(self, seed: int) -> None:
        """Add one pass."""
        self.fixed.append(self.render(1, seed)[1])
        image, seconds = self.render(self.samples, seed)
        self.seconds.append(seconds)
        self.total, self.squares = self.total + image, self.squares + image**2

    @property
    def second(self) -> float:
        """CPU time of one sample per pixel [s], by the least times: other load adds to them."""
        times, count = (self.long, LONG) if self.long else (self.seconds, 1)
        return max(min(times) - min(self.fixed), 1e-9) / (count * self.samples - 1)

    @property
    def image(self) -> np.ndarray:
        return self.total / len(self.seconds)

    @property
    def variance(self) -> float:
        """Variance of one sample per pixel, as a mean over all pixels."""
        passes = len(self.seconds)
        spread = (self.squares / passes - self.image**2) * passes / (passes - 1)
        return float(spread.mean()) * self.samples

    def bias(self, reference: Picture) -> float:
        """Estimate of the mean squared error of endless samples, at least 0."""
        noise = self.variance / (len(self.seconds) * self.samples) + reference.variance.mean()
        return max(metrics.mse(self.image, reference.image) - float(noise), 0.0)


def start(view: View, method: str) -> Method:
    """Load a scene and render it, so that its kernels are compiled."""
    started = Method(view.load(method)[0], method.startswith(PAPER))
    for spp in (1, LEAST_SPP):  # one sample per pixel has a kernel of its own
        started.render(spp, 0)
    return started


def at_equal_time(
    view: View, names: Sequence[str], samples: int, seconds: float
) -> tuple[dict[str, Method], Picture]:
    """Methods after alternating passes of about these seconds of CPU time each, and the truth.

    The system of Fan et al. (2022) is measured afterwards: its BSDFs would be compiled into the
    kernels of the others. It is slow: its passes have as many samples as keep `PASSES` of them
    within `SLOW` times the seconds, but `LEAST_SPP` at least, and it has no long renders.
    """
    reference = converged(view, WALK, samples)
    methods = {of: start(view, of) for of in names if not of.startswith(PAPER)}
    passes = spent = 0.0
    while passes < PASSES or spent < seconds * len(methods):
        for number, method in enumerate(methods.values()):
            method.sample(1000 * (int(passes) + 1) + number)
        passes, spent = passes + 1, sum(sum(method.seconds) for method in methods.values())
    for turn in range(LONG_TURNS):
        for method in methods.values():
            method.long.append(method.render(LONG * method.samples, turn)[1])
    for of in [name for name in names if name not in methods]:
        methods[of] = slow = start(view, of)
        affordable = LEAST_SPP * SLOW * seconds / (PASSES * slow.render(LEAST_SPP, 0)[1])
        slow.samples = int(min(max(affordable, LEAST_SPP), PASS_SPP))
        for index in range(PASSES):
            slow.sample(1000 * (index + 1) + len(methods))
        slow.scene = None
        gc.collect()
    return methods, reference
