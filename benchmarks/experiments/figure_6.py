"""Spheres of gold under one coat: both roughnesses, and the medium between; after Figure 6.

The left half of a sphere is rendered by `neural_layered`, the right half by the walk: an error
would show as a seam. E is that of pairs of directions.
"""

from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks import spheres
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.measures import error
from benchmarks.showing import figure, mosaic, percent, table
from gallery import stage

import urushi
from urushi.core import direction_sets

#: The grids: labels and values of rows and of columns.
GRIDS = {
    "roughness": (
        ("alpha of the coat", (0.05, 0.1, 0.2, 0.4)),
        ("alpha of the gold", (0.1, 0.2, 0.35, 0.6)),
    ),
    "media": (
        ("optical depth of the medium", (0.25, 0.5, 1.0, 2.0)),
        ("albedo of the medium", (0.0, 0.5, 0.9, 1.0)),
    ),
}
#: What a grid does not vary, and the gold's reflectance.
COAT = {"alpha": 0.1, "eta": 1.5, "sigma_t": 0.25, "albedo": 0.7, "g": 0.0}
BOTTOM, GOLD = 0.2, (1.0, 0.78, 0.34)
#: Pixels of a sphere, samples of a pixel, and pairs and walks for E.
SIZE, SAMPLES, PAIRS, WALKS, SEED = 128, 256, 300, 1 << 15, 6


def cases(_: Options) -> dict[str, Any]:
    """Parameters of the coat, and the width of the gold."""
    return {
        f"{grid}, {row:g}, {column:g}": (
            (COAT | {"alpha": row}, column)
            if grid == "roughness"
            else (COAT | {"sigma_t": row, "albedo": column}, BOTTOM)
        )
        for grid, ((_, rows), (_, columns)) in GRIDS.items()
        for row in rows
        for column in columns
    }


def measure(case: Any, options: Options) -> tuple[list[float], dict[str, np.ndarray]]:
    """E of the material and of one standard error of the walk, against the walk; the sphere."""
    coat, bottom = case
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(SEED), PAIRS, lowest_cosine=0.02)
    stack = urushi.coat(urushi.conductor(alpha=bottom, r0=GOLD), **coat)
    f, se = urushi.simulate(stack, wi, wo, walks=options.count(WALKS, 64), seed=SEED)
    ours = urushi.encode(stack, options.weights).f(wi, wo)
    halves = [sphere(name, coat, bottom, options) for name in ("neural_layered", "layered")]
    joined = np.where(np.arange(SIZE)[:, None] < SIZE // 2, *halves)
    return [error(x, f, wi, wo) for x in (ours, f + se)], {"sphere": joined}


def sphere(plugin: str, coat: dict[str, float], bottom: float, options: Options) -> np.ndarray:
    """The picture of the sphere by a plugin."""
    medium = {name: value for name, value in coat.items() if name != "eta"}
    bsdf = {"type": plugin, **medium, "int_ior": coat["eta"], "ext_ior": 1.0}
    bsdf["bottom"] = stage.conductor("none", bottom) | {"specular_reflectance": stage.rgb(*GOLD)}
    scene = spheres.scene(bsdf, SIZE)
    return np.array(mi.render(scene, spp=options.count(SAMPLES), seed=SEED))


def plot(found: Found, pictures: Pictures) -> Any:
    """Both grids of spheres, with E below each."""
    picture = figure(10, 5.2)
    axes = picture.subplots(1, 2)
    for axis, (grid, ((row_label, rows), (column_label, columns))) in zip(
        axes, GRIDS.items(), strict=True
    ):
        whole = [[pictures(f"{grid}, {y:g}, {x:g}")["sphere"] for x in columns] for y in rows]
        mosaic(axis, whole, [f"{value:g}" for value in rows], [f"{value:g}" for value in columns])
        axis.set(xlabel=column_label, ylabel=row_label)
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                text = f"E {percent(found[f'{grid}, {row:g}, {column:g}'][0])}"
                place = (j + 0.5) * SIZE, (i + 0.975) * SIZE
                axis.text(*place, text, color="white", fontsize=6.5, ha="center", va="bottom")
    picture.suptitle("Left half of a sphere: neural_layered. Right half: random walk.", fontsize=10)
    return picture


def tables(found: Found) -> list[str]:
    """Mean and largest E of each grid, and the walk's own error."""
    rows = []
    for grid in GRIDS:
        values = np.array([value for name, value in found.items() if name.startswith(grid)])
        if len(values):
            e, own = values.T
            rows.append([grid, *(f"{100 * x:.2g}" for x in (e.mean(), e.max(), own.mean()))])
    return [table(["grid", "E [%]: mean", "largest", "of the walk"], rows)]


EXPERIMENT = Experiment(cases, tables, measure, plot, models=NETWORKS, minutes=2)
