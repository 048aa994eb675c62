"""Scenes of the gallery by networks and by the walk: at equal time, and at one sample per pixel.

    python -m figures.scenes.compute

The reference is the walk at many samples. For equal time, passes of both methods alternate in one
process (`benchmarks.quality.equal_time`), and the networks get as many samples as fit into the CPU
time of `COUNT` samples of the walk.
"""

import argparse
import functools
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np
from benchmarks.quality import equal_time, pictures
from benchmarks.quality.converged import REFERENCE, Picture, converged
from benchmarks.scenes import BOTH, OWN, POINT, TEXTURED

from figures import results
from urushi.core import error_metrics as metrics
from urushi.nets.weights import DEFAULT, default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("scenes")
#: Samples per pixel of the walk at equal time.
COUNT = 16
#: Width of pictures, scale of textures, samples of the reference, and seconds of each method.
WIDTH, DETAIL, SAMPLES, SECONDS = 240, 0.5, 1024, 4.0
METHODS = {"walk": REFERENCE, "networks": DEFAULT}
#: Seeds of the pictures; those of the reference are hashes.
SEEDS = {"walk": 1, "networks": 2}


@dataclass(frozen=True)
class Case:
    """What is rendered, and how.

    Attributes:
        scene, light: as of `benchmarks.scenes.describe`.
        equal_time: whether both methods have equal time, instead of one sample per pixel.
        depth: longest path; 2: direct light alone.
        title: of the panel.
    """

    scene: str
    light: str
    equal_time: bool
    depth: int
    title: str


CASES = {
    "still-life": Case(TEXTURED, OWN, True, 6, "still life, alpha and index textured"),
    "globe": Case("globe", OWN, True, 6, "globe"),
    "teapot": Case("teapot", OWN, True, 6, "teapot"),
    "brushed": Case("brushed", OWN, True, 6, "brushed"),
    "shoe": Case("shoe", BOTH, True, 6, "shoe, point light and studio"),
    "shoe-1": Case("shoe", BOTH, False, 6, "shoe, point light and studio"),
    "shoe-point": Case("shoe", POINT, False, 2, "shoe, point light alone"),
}


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    parts = {name: functools.partial(part, name) for name in CASES}
    found = results.collect(PARTS, parts)
    head = {"weights": default_model().fingerprint}
    results.write(FOLDER / "results.json", {**head, "scenes": found})


def part(
    name: str,
    width: int = WIDTH,
    samples: int = SAMPLES,
    seconds: float = SECONDS,
    folder: Path = PARTS,
) -> dict[str, dict[str, float]]:
    """Samples per pixel, relative mean squared error and FLIP of both methods.

    The pictures are written into the folder as `NAME.npz`. The reference's noise is subtracted from
    the squared error, and is part of FLIP.
    """
    case = CASES[name]
    arguments = argparse.Namespace(
        width=width,
        detail=DETAIL,
        depth=case.depth,
        seconds=seconds,
        folder=folder / "references",
    )
    reference = converged(case.scene, REFERENCE, samples, arguments, case.light)
    methods = {
        method: equal_time.start(case.scene, case.light, plugin, arguments)
        for method, plugin in METHODS.items()
    }
    counts = {"walk": 1, "networks": 1}
    if case.equal_time:
        speed = relative_time(methods, reference, seconds)
        counts = {"walk": COUNT, "networks": max(1, round(COUNT / speed))}
    images = {"reference": reference.image}
    for method, count in counts.items():
        picture = mi.render(methods[method].scene, spp=count, seed=SEEDS[method])
        images[method] = np.array(picture, np.float64)
    results.write_pictures(folder / f"{name}.npz", images)
    variance = metrics.halves_variance(reference.first, reference.second)
    found = {}
    for method, count in counts.items():
        error = metrics.relative_mse(images[method], reference.image, variance=variance)
        shown = (metrics.shown(image) for image in (images[method], reference.image))
        flip = float(pictures.flip_map(*shown).mean())
        found[method] = {"samples": count, "relative_mse": error, "flip": flip}
    return found


def relative_time(
    methods: dict[str, equal_time.Method], reference: Picture, seconds: float
) -> float:
    """CPU time of one sample per pixel of the networks over one of the walk."""
    walk, networks = (methods[name] for name in METHODS)
    while walk.passes < equal_time.PASSES or sum(walk.seconds) < seconds:
        for number, method in enumerate((walk, networks)):
            equal_time.sample(method, 1000 * (walk.passes + 1) + number, reference)
    return networks.second / walk.second


if __name__ == "__main__":
    main()
