"""Measured materials under coats: `python -m benchmarks.quality.coated_measured FILE...`.

FILEs are MERL tables, RGL materials, folders of these, or archives of stand-ins as in
`benchmarks.quality.measured`. For each material and coat, prints the error E (docs/conventions.md),
in per cent and as a mean over channels, between the random walk through a coat over the measured
BRDF and the coat over its encoded material, which has a table,
`urushi.layer(coat, urushi.encode(measured))`. Also prints E of the bare encoded
material, the walk's own noise, the means, and the five largest errors. `--picture FILE.png` draws
spheres of the five materials with the largest mean, walk and network side by side. Takes about 12
seconds of CPU time for a material, and 20 for one whose spheres are drawn.
"""

import argparse
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mitsuba as mi
import numpy as np
from benchmarks.quality.measured import find_sets
from benchmarks.rivals.comparisons import Measured, Reciprocal

import urushi
from urushi.core import direction_sets, error_metrics
from urushi.errors import UrushiWarning
from urushi.material import Material
from urushi.measured.tabulated import MeasuredSurface

#: Pairs of directions of E, and walks for each pair and channel; walks for each node of a sphere.
PAIRS, WALKS, SPHERE_WALKS = 300, 4096, 8

#: Number of materials that are listed as the worst, and drawn.
WORST = 5

COATS = {
    "clear smooth": {"alpha": 0.03, "eta": 1.5},
    "clear rough": {"alpha": 0.3, "eta": 1.5},
    "tinted": {"alpha": 0.1, "eta": 1.5, "albedo": 0.0, "sigma_t": (0.1, 0.4, 1.2)},
    "scattering": {
        "alpha": 0.1, "eta": 1.4, "albedo": (0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3,
    },
}  # fmt: skip


class Row(NamedTuple):
    """Errors E of one material: encoded and bare, under every coat, and the walk's noise there."""

    bare: float
    coated: list[float]
    noise: list[float]


def load(material: Measured) -> MeasuredSurface:
    """The BRDF in the form that the walk samples."""
    loaded = material.load()
    return loaded.source if isinstance(loaded, Reciprocal) else loaded


def coated(material: Any, coat: dict, layer: Callable[..., Any] = urushi.layer) -> Any:
    """The material under a coat; layer: of the material's system."""
    medium = {name: value for name, value in coat.items() if name not in ("alpha", "eta")}
    return layer(urushi.dielectric(coat["alpha"], coat["eta"]), material, **medium)


def error(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """E, the mean over channels of values (N, C)."""
    return float(error_metrics.stack_error(f_hat.T, f.T, wi[:, 2], wo[:, 2]).mean())


def measured(surface: MeasuredSurface, material: Material) -> Row:
    """E of an encoded surface."""
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(0), PAIRS)
    truth = 0.5 * (surface.f(wi, wo) + surface.f(wo, wi))
    row = Row(error(material.f(wi, wo), truth, wi, wo), [], [])
    for coat in COATS.values():
        stack = urushi.coat(surface, **coat)
        f, se = urushi.simulate(stack, wi, wo, walks=WALKS, progress=False)
        row.coated.append(error(coated(material, coat).f(wi, wo), f, wi, wo))
        # The mean size of a normal error is 0.8 of its deviation.
        row.noise.append(error(f + 0.8 * se, f, wi, wo))
    return row


def draw(path: Path, chosen: dict[str, tuple[MeasuredSurface, Material]]) -> None:
    """Spheres in a studio: one row for each material; for each coat, walk and network."""
    from benchmarks.quality import sphere
    from matplotlib import pyplot as plt

    light = sphere.exposed(sphere.own_environments()[0])
    columns = 2 * len(COATS)
    figure, axes = plt.subplots(
        len(chosen), columns, figsize=(1.3 * columns, 1.35 * len(chosen) + 0.3), squeeze=False
    )
    for row, (name, (surface, material)) in zip(axes, chosen.items(), strict=True):
        for index, (label, coat) in enumerate(COATS.items()):
            stack = urushi.coat(surface, **coat)

            def walked(wi: np.ndarray, wo: np.ndarray, stack: urushi.Stack = stack) -> np.ndarray:
                return urushi.simulate(stack, wi, wo, walks=SPHERE_WALKS, progress=False)[0]

            pictures = [sphere.render(f, [light])[0] for f in (walked, coated(material, coat).f)]
            for side, picture in enumerate(pictures):
                place = row[2 * index + side]
                place.imshow(np.clip(picture, 0, 1) ** (1 / 2.2))
                place.set_xticks([])
                place.set_yticks([])
                if place in axes[0]:
                    place.set_title(f"{label}\n{('walk', 'network')[side]}", fontsize=8)
        row[0].set_ylabel(name, fontsize=7)
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=150)


def show(name: str, bare: float, values: list[float], noise: float) -> None:
    """Print one line of the table."""
    cells = [bare, *values, float(np.mean(values)), noise]
    print(f"{name:28}" + "".join(f"{100 * cell:14.2f}" for cell in cells), flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.coated_measured",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("measured", type=Path, nargs="+", help="files, folders or archives")
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("--picture", type=Path, help="where to draw spheres of the worst materials")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    warnings.simplefilter("ignore", UrushiWarning)  # RGL files are not reciprocal
    sets = find_sets(options.measured, None)
    materials = [material for members in sets.values() for material in members]
    if not materials:
        given = ", ".join(map(str, options.measured))
        parser.error(
            f"{given}: no .binary or .bsdf file there; give files, folders or .npz archives"
        )
    header = ("bare", *COATS, "mean of coats", "noise")
    print(f"{'E [%]':28}" + "".join(f"{name:>14}" for name in header))
    rows: list[Row] = []
    for material in materials:
        surface = load(material)
        row = measured(surface, urushi.encode(surface, options.weights))
        rows.append(row)
        show(material.name, row.bare, row.coated, float(np.mean(row.noise)))
    every = np.array([row.coated for row in rows])
    noise = float(np.mean([row.noise for row in rows]))
    show("mean", float(np.mean([row.bare for row in rows])), list(every.mean(0)), noise)

    print(f"\nthe worst of {every.size}:")
    for index in np.argsort(every, axis=None)[::-1][:WORST]:
        number, coat = np.unravel_index(index, every.shape)
        name = f"{materials[number].name}, {list(COATS)[coat]}"
        print(f"  {name:44}{100 * every[number, coat]:8.2f}")
    if options.picture:
        worst = np.argsort(every.mean(1))[::-1][:WORST]
        surfaces = {materials[i].name: load(materials[i]) for i in worst}
        draw(
            options.picture,
            {
                name: (surface, urushi.encode(surface, options.weights))
                for name, surface in surfaces.items()
            },
        )


if __name__ == "__main__":
    main()
