"""Spheres of coated materials by Belcour 2018, by the walk and by codes; after Figure 7.

Every method renders the same spheres in one studio, in the time in which codes take `SAMPLES`
samples for each pixel, and with many more samples to measure the bias. The reference is the walk
with `REFERENCE` samples. Times are CPU times of a sample.
"""

import gc
from functools import partial
from typing import Any, NamedTuple

import benchmarks.scenes  # noqa: F401 (registers the rivals' plugins)
import mitsuba as mi
import numpy as np
from benchmarks import spheres, timing
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.showing import figure, table
from gallery import stage

from urushi.core import error_metrics as metrics

#: Methods and their plugins, in the order of the figure's rows; the walk is also the reference.
PLUGINS = {"Belcour 2018": "layered_belcour", "walk": "layered", "networks": "neural_layered"}
#: Pixels along a side, samples of a pixel by codes, renders whose errors are averaged, samples of
#: the reference and of the other methods' pictures that measure their bias.
SIZE, SAMPLES, RENDERS, REFERENCE, ENDLESS = 160, 16, 8, 1024, 512
#: Samples of a pass of long renders, and turns of the measurement of times.
PASS, TURNS = 64, 3


class Layered(NamedTuple):
    """A bottom, and its coats from the lowest to the topmost: parameters of the plugins."""

    bottom: dict[str, Any]
    coats: list[dict[str, Any]]

    def bsdf(self, plugin: str) -> dict[str, Any]:
        described = self.bottom
        for coat in self.coats:
            described = {"type": plugin, **coat, "bottom": described}
        return described


def cases(_: Options) -> dict[str, Layered]:
    """The materials by name."""
    clear = {"alpha": 0.05, "int_ior": 1.5, "ext_ior": 1.0}
    gold, rgb = stage.conductor("Au", 0.2), stage.rgb
    milk = {"alpha": 0.1, "albedo": rgb(0.9, 0.95, 0.98), "sigma_t": 1.0}
    blue = {"alpha": 0.2, "albedo": rgb(0.4, 0.7, 0.9), "sigma_t": rgb(0.8, 0.4, 0.2)}
    red = {"alpha": 0.1, "sigma_t": rgb(0.02, 0.3, 1.2)}
    rough = {"alpha": 0.4, "int_ior": 1.6}
    return {
        "green paint, clear coat": Layered(stage.diffuse(0.05, 0.35, 0.25), [clear]),
        "rough gold, clear coat": Layered(gold, [clear]),
        "copper, rough clear coat": Layered(stage.conductor("Cu", 0.1), [clear | rough]),
        "aluminium, absorbing coat": Layered(stage.conductor("Al", 0.2), [clear | red]),
        "gold, scattering coat": Layered(gold, [clear | milk]),
        "silver, blue coat, clear coat": Layered(
            stage.conductor("Ag", 0.2), [clear | blue, clear | {"int_ior": 1.4}]
        ),
    }


def measure(layers: Layered, options: Options) -> tuple[Found, dict[str, np.ndarray]]:
    """By method, relative mean squared errors of the sphere; and the column of pictures.

    `time` of a sample over that of codes, `samples` in the same time, the `error` with them, a mean
    over renders, and the `bias`, the error that remains with many samples (0: the walk).
    """
    gc.collect()  # BSDFs in memory are compiled into every kernel
    loaded = {name: spheres.scene(layers.bsdf(plugin), SIZE) for name, plugin in PLUGINS.items()}
    operations = {
        (name, spp): partial(timing.seconds, partial(_render, scene, spp))
        for name, scene in loaded.items()
        for spp in (1, PASS)
    }
    least = timing.least(operations, TURNS)  # type: ignore[arg-type]
    sample = {name: least[name, PASS] - least[name, 1] for name in loaded}  # type: ignore[index]
    truth, noise = accumulated(loaded["walk"], options.count(REFERENCE, 2 * PASS))
    inside = truth.sum(axis=-1) > 0
    found, images = {}, {}
    for number, (name, scene) in enumerate(loaded.items(), 1):
        ratio = sample[name] / sample["networks"]
        samples = max(1, round(SAMPLES / ratio))
        renders = [_render(scene, samples, seed) for seed in range(RENDERS)]
        error = [_error(image[inside], truth[inside], noise[inside]) for image in renders]
        bias, images[name] = 0.0, renders[0]
        if name != "walk":
            endless = options.count(ENDLESS, 2 * PASS)
            image, own = accumulated(scene, endless, seed=number * 100_000)
            bias = _error(image[inside], truth[inside], (noise + own)[inside])
        values = {"time": ratio, "samples": samples, "error": np.mean(error), "bias": bias}
        found[name] = {key: float(f"{value:.3g}") for key, value in values.items()}
    return found, images | {"reference": truth}


def _render(scene: "mi.Scene", spp: int, seed: int = 0) -> np.ndarray:
    return np.array(mi.render(scene, spp=spp, seed=seed))


def _error(image: np.ndarray, truth: np.ndarray, variance: np.ndarray) -> float:
    return metrics.relative_mse(image, truth, variance=variance)


def accumulated(
    scene: "mi.Scene", samples: int, seed: int = 10_000
) -> tuple[np.ndarray, np.ndarray]:
    """The mean picture (H, W, 3) of many samples, and an estimate of its variance.

    Pictures that are compared need seeds that are far apart: of equal seeds, noise is correlated.
    """
    passes = max(1, samples // PASS // 2)
    halves = [
        np.mean([_render(scene, PASS, s) for s in range(first, first + passes)], 0)
        for first in (seed, seed + passes)
    ]
    return np.mean(halves, axis=0), metrics.halves_variance(*halves)


def plot(found: Found, pictures: Pictures) -> Any:
    """A column for each material, a row for each method."""
    picture = figure(8.6, 6.9)
    axes = picture.subplots(len(PLUGINS) + 1, len(found))
    for column, (material, methods) in enumerate(found.items()):
        axes[0, column].set_title(material.replace(", ", ",\n"), fontsize=9)
        for row, name in enumerate([*PLUGINS, "reference"]):
            axis = axes[row, column]
            axis.imshow(pictures(material)[name])
            axis.set(xticks=[], yticks=[])
            if column == 0:
                end = "\nconverged" if name == "reference" else ",\nequal time"
                axis.set_ylabel(name.replace("reference", "walk,") + end, fontsize=9)
            text = f"{REFERENCE} samples"
            if name in methods:
                of = methods[name]
                text = f"error {of['error']:.2g}\n{of['samples']:.0f} samples"
            axis.set_xlabel(text, fontsize=8)
    return picture


def tables(found: Found) -> list[str]:
    """A row for each material."""
    columns = [("time", name) for name in PLUGINS if name != "networks"]
    columns += [("error", name) for name in PLUGINS]
    columns += [("bias", name) for name in PLUGINS if name != "walk"]
    rows = [
        [material, *(f"{methods[name][key]:.2g}" for key, name in columns)]
        for material, methods in found.items()
    ]
    return [table(["material", *map(", ".join, columns)], rows)]


EXPERIMENT = Experiment(cases, measure, tables, plot, models=NETWORKS, minutes=9)
