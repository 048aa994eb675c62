"""Spheres of coated materials by Belcour 2018, by the walk and by codes; after Figure 7.

Every method renders the same spheres in one studio, in the time in which codes take `SAMPLES`
samples for each pixel, and with many more samples to measure the bias. The reference is the walk
with `REFERENCE` samples. Times are CPU times of a sample.
"""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks import spheres
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.pictures import Picture, at_equal_time, converged
from benchmarks.scenes import View
from benchmarks.showing import grid, table
from gallery import stage

from urushi.core import error_metrics as metrics

#: Methods and their plugins, in the order of the figure's rows; the walk is also the reference.
PLUGINS = {"Belcour 2018": "layered_belcour", "walk": "layered", "networks": "neural_layered"}
#: Pixels along a side, samples of a pixel by codes, renders whose errors are averaged, samples of
#: the reference and of the other methods' pictures that measure their bias, and CPU seconds of the
#: measurement of a method's time.
SIZE, SAMPLES, RENDERS, REFERENCE, ENDLESS, SECONDS = 160, 16, 8, 1024, 512, 2.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sphere(View):
    """A bottom, and its coats from the lowest to the topmost: parameters of the plugins."""

    bottom: dict[str, Any]
    coats: list[dict[str, Any]]

    def described(self, method: str, folder: Path) -> dict[str, Any]:
        bsdf = self.bottom
        for coat in self.coats:
            bsdf = {"type": method, **coat, "bottom": bsdf}
        return spheres.described(bsdf, SIZE, folder)


def cases(_: Options) -> dict[str, Sphere]:
    """The materials by name."""
    clear = {"alpha": 0.05, "int_ior": 1.5, "ext_ior": 1.0}
    gold, rgb = stage.conductor("Au", 0.2), stage.rgb
    milk = {"alpha": 0.1, "albedo": rgb(0.9, 0.95, 0.98), "sigma_t": 1.0}
    blue = {"alpha": 0.2, "albedo": rgb(0.4, 0.7, 0.9), "sigma_t": rgb(0.8, 0.4, 0.2)}
    red = {"alpha": 0.1, "sigma_t": rgb(0.02, 0.3, 1.2)}
    rough = {"alpha": 0.4, "int_ior": 1.6}
    layers = {
        "green paint, clear coat": (stage.diffuse(0.05, 0.35, 0.25), [clear]),
        "rough gold, clear coat": (gold, [clear]),
        "copper, rough clear coat": (stage.conductor("Cu", 0.1), [clear | rough]),
        "aluminium, absorbing coat": (stage.conductor("Al", 0.2), [clear | red]),
        "gold, scattering coat": (gold, [clear | milk]),
        "silver, blue coat, clear coat": (
            stage.conductor("Ag", 0.2),
            [clear | blue, clear | {"int_ior": 1.4}],
        ),
    }
    return {
        name: Sphere(name, bottom=bottom, coats=coats) for name, (bottom, coats) in layers.items()
    }


def measure(sphere: Sphere, options: Options) -> tuple[Found, dict[str, np.ndarray]]:
    """By method, relative mean squared errors of the sphere; and the column of pictures.

    `time` of a sample over that of codes, `samples` in the same time, the `error` with them, a mean
    over renders, and the `bias`, the error that remains with many samples (0: the walk).
    """
    count, seconds = options.count(REFERENCE, 32), options.share * SECONDS
    methods, truth = at_equal_time(sphere, list(PLUGINS.values()), count, seconds)
    found, images = {}, {"reference": truth.image}
    for name, plugin in PLUGINS.items():
        method = methods[plugin]
        ratio = method.second / methods[PLUGINS["networks"]].second
        samples, bias = max(1, round(SAMPLES / ratio)), 0.0
        renders = [method.render(samples, seed)[0] for seed in range(RENDERS)]
        error = np.mean([_error(image, truth, 0) for image in renders])
        if name != "walk":
            endless = converged(sphere, plugin, options.count(ENDLESS, 32))
            bias = _error(endless.image, truth, endless.variance)
        found[name] = {"time": ratio, "samples": samples, "error": error, "bias": bias}
        images[name] = renders[0]
    return found, images


def _error(image: np.ndarray, truth: Picture, own: Any) -> float:
    """Relative mean squared error of the sphere's pixels without noise; own: the image's."""
    inside = truth.image.sum(axis=-1) > 0
    variance = (truth.variance + own)[inside]
    return metrics.relative_mse(image[inside], truth.image[inside], variance=variance)


def plot(found: Found, pictures: Pictures) -> Any:
    """A column for each material, a row for each method."""
    rows = []
    for name in PLUGINS:
        parts = [methods[name] for methods in found.values()]
        notes = [f"error {of['error']:.2g}\n{of['samples']:.0f} samples" for of in parts]
        rows.append((f"{name},\nequal time", [pictures(x)[name] for x in found], notes))
    truth, notes = [pictures(x)["reference"] for x in found], [f"{REFERENCE} samples"] * len(found)
    rows.append(("walk,\nconverged", truth, notes))
    return grid((8.6, 6.9), [material.replace(", ", ",\n") for material in found], rows)


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


EXPERIMENT = Experiment(cases, tables, measure, plot, models=NETWORKS, minutes=9)
