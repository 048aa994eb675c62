"""Error at equal time of networks, walk and an ideal BSDF, in scenes under three kinds of light.

    python -m figures.light.compute

Uses the measurement of `benchmarks.quality.equal_time` with small pictures: passes of the walk, of
the networks and of Mitsuba's `principled` alternate in one process. Ratios of mean squared errors
at equal CPU time are for the time in which the walk takes `COUNT` samples per pixel.
"""

import argparse
import functools
from pathlib import Path

import mitsuba as mi
from benchmarks.quality import equal_time
from benchmarks.quality.converged import REFERENCE
from benchmarks.scenes import LIGHTS, PRINCIPLED

from figures import results
from urushi.nets.weights import DEFAULT, default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("light")
SCENES = ("still-life", "globe", "teapot")
#: Samples per pixel of the walk that give the time of the comparison.
COUNT = 64
#: Width of pictures, scale of textures, samples of the reference, and seconds of each method.
WIDTH, DETAIL, SAMPLES, SECONDS = 96, 0.25, 512, 6.0
#: Longest path: direct light. Caustics of small lights are single bright samples, which path
#: tracing hardly finds, and which would decide the means.
DEPTH = 2


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    parts = {f"{s}, {light}": functools.partial(part, s, light) for s in SCENES for light in LIGHTS}
    found = results.collect(PARTS, parts)
    head = {"weights": default_model().fingerprint}
    results.write(FOLDER / "results.json", {**head, "parts": found})


def part(
    scene: str, light: str, width: int = WIDTH, samples: int = SAMPLES, seconds: float = SECONDS
) -> dict[str, float]:
    """Costs and variances of the networks over the walk's, and what both ratios are worth.

    Returns:
        `time` and `variance` of a sample over the walk's, `bias` over the walk's variance, and the
        walk's mean squared error at equal time over that of the `networks` and of an `exact` BSDF
        without noise that costs what `principled` does.
    """
    arguments = argparse.Namespace(
        weights=[DEFAULT],
        width=width,
        detail=DETAIL,
        depth=DEPTH,
        spp=samples,
        seconds=seconds,
        folder=PARTS / "pictures",
    )
    methods, reference = equal_time.measure(scene, light, arguments)
    walk, ours, cheap = (methods[name] for name in (REFERENCE, DEFAULT, PRINCIPLED))
    time, variance = ours.second / walk.second, ours.variance / walk.variance
    bias = max(ours.bias(reference), 0.0) / walk.variance
    return {
        "time": time,
        "variance": variance,
        "bias": bias,
        "networks": 1 / COUNT / (variance * time / COUNT + bias),
        "exact": walk.second / (cheap.second * variance),
    }


if __name__ == "__main__":
    main()
