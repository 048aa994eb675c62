"""Mean squared errors of networks and of the random walk at equal time, in the paper's scenes.

    python -m figures.table_3.compute

The walk takes the samples per pixel of Fan et al. (2022), Table 3. The networks take as many as
their cost allows in the same CPU time, which turns of both measure first. Then each method renders
independent pictures, and each is compared with a converged picture of the walk.
"""

import argparse
import functools
import time
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality.converged import REFERENCE, Picture, converged, load

from figures import results
from urushi.core import error_metrics as metrics
from urushi.nets.weights import DEFAULT, default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("table_3")
#: Samples per pixel of the walk, those of Guo et al. (2018) in the paper's table.
SAMPLES = {"still-life": 64, "globe": 24, "teapot": 12}
METHODS = {"networks": DEFAULT, "walk": REFERENCE}
#: Width of pictures, scale of textures, longest path, and samples of the reference.
WIDTH, DETAIL, DEPTH, CONVERGED = 128, 0.25, 6, 1024
#: Turns that measure the time, and pictures that measure the error of a method.
TURNS, PICTURES = 3, 12


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    parts = {scene: functools.partial(part, scene) for scene in SAMPLES}
    found = results.collect(PARTS, parts)
    head = {"weights": default_model().fingerprint}
    results.write(FOLDER / "results.json", {**head, "scenes": found})


def part(
    scene: str, width: int = WIDTH, reference: int = CONVERGED, pictures: int = PICTURES
) -> dict[str, Any]:
    """Errors at equal time in a scene.

    Returns:
        The picture's `size`, the `noise` of the reference (its mean squared error), which is
        subtracted, and for each method its samples per pixel `spp`, the CPU `seconds` of a picture
        (median) and `mse`, the mean squared error of each picture.
    """
    arguments = argparse.Namespace(
        width=width, detail=DETAIL, depth=DEPTH, folder=PARTS / "pictures"
    )
    truth = converged(scene, REFERENCE, reference, arguments)
    scenes = {name: load(scene, method, arguments)[0] for name, method in METHODS.items()}
    spp = equal_time(scenes, SAMPLES[scene])
    measured: dict[str, list[tuple[float, float]]] = {name: [] for name in METHODS}
    for turn in range(pictures):
        for place, (name, loaded) in enumerate(scenes.items()):
            seed = 1 + place + len(METHODS) * turn
            measured[name].append(picture(loaded, spp[name], seed, truth))
    found: dict[str, Any] = {"size": [width, width * 3 // 4], "noise": float(f"{truth.noise:.3g}")}
    for name, values in measured.items():
        seconds, errors = np.array(values).T
        found[name] = {
            "spp": spp[name],
            "seconds": round(float(np.median(seconds)), 3),
            "mse": results.rounded(errors),
        }
    return found


def equal_time(scenes: dict[str, Any], samples: int) -> dict[str, int]:
    """Samples per pixel of each method that cost as much CPU time as those of the walk.

    A picture's time is a fixed part and one that is proportional to its samples; both are taken
    from pictures of few samples and of the walk's number.
    """
    counts = 1, max(samples, 16)
    least = {name: np.full(2, np.inf) for name in scenes}
    for turn in range(TURNS + 1):
        for name, scene in scenes.items():
            spent = np.array([rendered(scene, count, turn)[1] for count in counts])
            if turn > 0:  # the first one compiles
                least[name] = np.minimum(least[name], spent)
    slopes = {name: (b - a) / (counts[1] - counts[0]) for name, (a, b) in least.items()}
    budget = least["walk"][0] + slopes["walk"] * (samples - 1)
    return {
        name: samples
        if name == "walk"
        else max(1, round(1 + (budget - least[name][0]) / slopes[name]))
        for name in scenes
    }


def rendered(scene: Any, samples: int, seed: int) -> tuple[np.ndarray, float]:
    """A picture (H, W, 3), and its CPU time [s]."""
    begin = time.process_time()
    image = np.array(mi.render(scene, spp=samples, seed=seed), dtype=np.float64)
    return image, time.process_time() - begin


def picture(scene: Any, samples: int, seed: int, truth: Picture) -> tuple[float, float]:
    """CPU time [s] of one picture, and its mean squared error without that of the reference."""
    image, seconds = rendered(scene, samples, seed)
    return seconds, metrics.mse(image, truth.image) - truth.noise


if __name__ == "__main__":
    main()
