"""Spheres of coated materials by Belcour 2018, by the random walk and by the networks.

    python -m figures.figure_7.compute

Every method renders the same spheres in one studio, in the time in which the networks take
`SAMPLES` samples for each pixel, and with many more samples to measure the bias. The reference is
the walk with `REFERENCE` samples. Times are CPU times of a sample; the methods are timed
alternately in one process.
"""

import functools
import gc
import time
from pathlib import Path
from typing import Any, NamedTuple

import benchmarks.scenes  # noqa: F401 (registers the rivals' plugins)
import mitsuba as mi
import numpy as np
from gallery import stage

from figures import results, sphere
from urushi.core import error_metrics as metrics
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("figure_7")
#: Methods and their plugins, in the order of the figure's rows; the walk is also the reference.
PLUGINS = {
    "Belcour 2018": "layered_belcour",
    "walk": "layered",
    "networks": "neural_layered",
}
#: Pixels along a side, samples of a pixel by the networks, renders whose errors are averaged,
#: samples of the reference and of the other methods' pictures that measure their bias.
SIZE, SAMPLES, RENDERS, REFERENCE, ENDLESS = 160, 16, 8, 1024, 512
#: Samples of a pass of long renders; and samples and turns of the measurement of times.
PASS, LONG, TURNS = 64, 64, 3


class Layered(NamedTuple):
    """A bottom, and its coats from the lowest to the topmost: parameters of the plugins."""

    bottom: dict[str, Any]
    coats: list[dict[str, Any]]


def materials() -> dict[str, Layered]:
    """The materials by name."""
    clear = {"alpha": 0.05, "int_ior": 1.5, "ext_ior": 1.0}
    red = stage.rgb(0.02, 0.3, 1.2)
    return {
        "green paint,\nclear coat": Layered(stage.diffuse(0.05, 0.35, 0.25), [clear]),
        "rough gold,\nclear coat": Layered(stage.conductor("Au", 0.2), [clear]),
        "copper,\nrough clear coat": Layered(
            stage.conductor("Cu", 0.1), [clear | {"alpha": 0.4, "int_ior": 1.6}]
        ),
        "aluminium,\nabsorbing coat": Layered(
            stage.conductor("Al", 0.2), [clear | {"alpha": 0.1, "sigma_t": red}]
        ),
        "gold,\nscattering coat": Layered(
            stage.conductor("Au", 0.2),
            [clear | {"alpha": 0.1, "albedo": stage.rgb(0.9, 0.95, 0.98), "sigma_t": 1.0}],
        ),
        "silver, blue coat,\nclear coat": Layered(
            stage.conductor("Ag", 0.2),
            [
                clear
                | {
                    "alpha": 0.2,
                    "albedo": stage.rgb(0.4, 0.7, 0.9),
                    "sigma_t": stage.rgb(0.8, 0.4, 0.2),
                },
                clear | {"int_ior": 1.4},
            ],
        ),
    }


def main() -> None:
    """Compute what is missing and write results.json; pictures stay beside the finished parts."""
    mi.set_variant("llvm_ad_rgb")
    times = results.collect(
        PARTS / "times",
        {file_name(m): functools.partial(cost, layers) for m, layers in materials().items()},
    )
    found = results.collect(
        PARTS / "errors",
        {
            file_name(m): functools.partial(errors, m, layers, times[file_name(m)])
            for m, layers in materials().items()
        },
    )
    head = {"weights": default_model().fingerprint}
    by_material = {m: found[file_name(m)] for m in materials()}
    results.write(FOLDER / "results.json", {**head, "materials": by_material})


def file_name(material: str) -> str:
    """The material's name as that of a file."""
    return material.replace("\n", " ").replace(",", "").replace(" ", "_")


def picture_file(material: str) -> Path:
    """The file of a material's column of pictures."""
    return PARTS / "errors" / f"{file_name(material)}.npz"


def bsdf(plugin: str, layers: Layered) -> dict[str, Any]:
    """The material's description by one of the plugins."""
    described = layers.bottom
    for coat in layers.coats:
        described = {"type": plugin, **coat, "bottom": described}
    return described


def scenes(layers: Layered, size: int) -> dict[str, "mi.Scene"]:
    """The loaded scene of each method; earlier ones, which every kernel contains, are released."""
    gc.collect()
    return {name: sphere.load(bsdf(plugin, layers), size) for name, plugin in PLUGINS.items()}


def cost(layers: Layered) -> dict[str, float]:
    """CPU time of a sample of each method over that of the networks."""
    loaded = scenes(layers, SIZE)
    seconds: dict[str, list[float]] = {name: [] for name in loaded}
    fixed: dict[str, list[float]] = {name: [] for name in loaded}
    for turn in range(TURNS + 1):
        for name, scene in loaded.items():
            for samples, into in ((1, fixed), (LONG, seconds)):
                begin = time.process_time()
                np.array(mi.render(scene, spp=samples, seed=turn))
                if turn > 0:  # the first one compiles
                    into[name].append(time.process_time() - begin)
    sample = {name: min(seconds[name]) - min(fixed[name]) for name in loaded}
    return {name: round(value / sample["networks"], 3) for name, value in sample.items()}


def errors(
    material: str,
    layers: Layered,
    time_ratio: dict[str, float],
    size: int = SIZE,
    reference: int = REFERENCE,
    endless: int = ENDLESS,
    renders: int = RENDERS,
) -> dict[str, dict[str, float]]:
    """Relative mean squared errors of each method on the sphere; stores the column of pictures.

    Returns:
        by method: `time` of a sample over the networks', `samples` in the same time, the `error`
        with them, a mean over renders, and the `bias`, the error that remains with many
        samples (0: the walk).
    """
    loaded = scenes(layers, size)
    truth, noise = accumulated(loaded["walk"], reference)
    inside = truth.sum(axis=-1) > 0
    found, pictures = {}, []
    for number, (name, scene) in enumerate(loaded.items(), 1):
        samples = max(1, round(SAMPLES / time_ratio[name]))
        images = [np.array(mi.render(scene, spp=samples, seed=seed)) for seed in range(renders)]
        error = [
            metrics.relative_mse(image[inside], truth[inside], variance=noise[inside])
            for image in images
        ]
        bias = 0.0
        if name != "walk":
            image, own = accumulated(scene, endless, seed=number * 100_000)
            variance = (noise + own)[inside]
            bias = metrics.relative_mse(image[inside], truth[inside], variance=variance)
        found[name] = {
            "time": time_ratio[name],
            "samples": samples,
            "error": float(f"{np.mean(error):.3g}"),
            "bias": float(f"{bias:.3g}"),
        }
        pictures.append(images[0])
    results.write_pictures(picture_file(material), {"spheres": np.stack([*pictures, truth])})
    return found


def accumulated(
    scene: "mi.Scene", samples: int, seed: int = 10_000
) -> tuple[np.ndarray, np.ndarray]:
    """The mean picture (H, W, 3) of many samples, and an estimate of its variance.

    Pictures that are compared need seeds that are far apart: of equal seeds, noise is correlated.
    """
    halves = []
    for half in (0, 1):
        passes = max(1, samples // PASS // 2)
        seeds = range(seed + half * passes, seed + (half + 1) * passes)
        halves.append(np.mean([np.array(mi.render(scene, spp=PASS, seed=s)) for s in seeds], 0))
    return np.mean(halves, axis=0), metrics.halves_variance(*halves)


if __name__ == "__main__":
    main()
