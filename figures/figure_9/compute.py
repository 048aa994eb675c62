"""Measured materials, bare and under coats, by the walk, by codes and by tables.

    URUSHI_TEST_DATA=FOLDER python -m figures.figure_9.compute

FOLDER has `data/rgl` with files of the RGL database, and in `data/merl_nbrdf` the archive of
published neural fits to MERL materials, whose tables stand in for MERL's files. Without it nothing
is computed. E is that of all materials; spheres show `SHOWN` of them, by their rank.
"""

import functools
import os
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality import sphere
from benchmarks.quality.coated_measured import error, load
from benchmarks.quality.measured import find_sets
from benchmarks.rivals.comparisons import Measured

import urushi
from figures import results
from urushi.core import direction_sets
from urushi.errors import UrushiWarning
from urushi.material import Material
from urushi.measured.tabulated import MeasuredSurface
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("figure_9")
#: Every eighth stand-in, from the fifth on; all RGL files.
FIRST, EVERY = 4, 8
#: Coats, from the lowest to the topmost.
MILK = {"alpha": 0.1, "eta": 1.4, "albedo": (0.95, 0.85, 0.7), "sigma_t": 0.5}
CLEAR = {"alpha": 0.05, "eta": 1.5}
COATS: dict[str, list[dict[str, Any]]] = {
    "bare": [],
    "clear coat": [CLEAR],
    "milky and clear coat": [MILK, CLEAR],
}
#: Representations, and the argument `table` of `urushi.encode`; None is the default. Both are
#: layered by light transport.
FORMS: dict[str, bool | None] = {"code": False, "table": None}
#: Materials that are drawn, as shares of the order by the codes' mean E under coats, from best to
#: worst.
SHOWN = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
#: Pairs of directions and walks for E; walks for each node of a sphere; seed of both.
PAIRS, WALKS, SPHERE_WALKS, SEED = 300, 1 << 13, 8, 9


def main() -> None:
    """Compute what is missing and write results.json; pictures stay beside the finished parts."""
    found_materials = materials()
    if not found_materials:
        print(
            "figure 9 is skipped: URUSHI_TEST_DATA names no folder with data/rgl and "
            "data/merl_nbrdf; set it to compute the figure"
        )
        return
    mi.set_variant("llvm_ad_rgb")
    warnings.simplefilter("ignore", UrushiWarning)  # RGL files are not reciprocal
    found = results.collect(
        PARTS / "errors",
        {m.name: functools.partial(errors, m) for m in found_materials},
    )
    chosen = shown(found)
    members = {m.name: m for m in found_materials}
    results.collect(
        PARTS / "spheres", {name: functools.partial(spheres, members[name]) for name in chosen}
    )
    head = {"weights": default_model().fingerprint, "shown": chosen}
    results.write(FOLDER / "results.json", {**head, "materials": found})


def materials() -> list[Measured]:
    """The RGL files and the stand-ins; empty if there are no data."""
    folder = Path(os.environ.get("URUSHI_TEST_DATA", "")) / "data"
    archives = sorted((folder / "merl_nbrdf").glob("*.npz"))
    if not archives or not (folder / "rgl").is_dir():
        return []
    sets = find_sets([folder / "rgl", archives[0]], None)
    rgl, stand_ins = sets["rgl"], sets[archives[0].stem]
    return [*rgl, *stand_ins[FIRST::EVERY]]


def picture_file(name: str) -> Path:
    """The file of a material's row of pictures."""
    return PARTS / "spheres" / f"{name}.npz"


def shown(found: dict[str, Any]) -> list[str]:
    """The names of the drawn materials, from best to worst."""
    order = sorted(found, key=lambda name: np.mean(list(found[name]["code"].values())[1:]))
    return [order[round(share * (len(order) - 1))] for share in SHOWN]


def stack(surface: MeasuredSurface, coats: list[dict[str, Any]]) -> Any:
    """The surface under coats, for the walk."""
    stacked: Any = surface
    for coat in coats:
        stacked = urushi.coat(stacked, **coat)
    return stacked


def layered(material: Material, coats: list[dict[str, Any]]) -> Material:
    """The encoded surface under coats; a code if it is one."""
    coded = material.table is None
    for coat in coats:
        medium = {name: value for name, value in coat.items() if name not in ("alpha", "eta")}
        material = urushi.layer(urushi.dielectric(coat["alpha"], coat["eta"]), material, **medium)
        material = replace(material, table=None) if coded else material
    return material


def encoded(surface: MeasuredSurface) -> dict[str, Material]:
    """The surface's material in each of `FORMS`."""
    return {form: urushi.encode(surface, table=table) for form, table in FORMS.items()}


def errors(measured: Measured, walks: int = WALKS) -> dict[str, Any]:
    """E of each of `FORMS` by name of the coats, and the walk's own `noise` there."""
    surface = load(measured)
    materials = encoded(surface)
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(SEED), PAIRS)
    found: dict[str, Any] = {"file": "RGL" if measured.is_rgl else "stand-in"}
    found |= {name: {} for name in (*FORMS, "noise")}
    for name, coats in COATS.items():
        if coats:
            f, se = urushi.simulate(
                stack(surface, coats), wi, wo, walks=walks, seed=SEED, progress=False
            )
        else:
            f, se = 0.5 * (surface.f(wi, wo) + surface.f(wo, wi)), np.float64(0)
        values = {form: layered(m, coats).f(wi, wo) for form, m in materials.items()}
        # The mean size of a normal error is 0.8 of its deviation.
        values["noise"] = f + 0.8 * se
        for form, own in values.items():
            found[form][name] = float(f"{error(own, f, wi, wo):.3g}")
    return found


def spheres(measured: Measured) -> list[str]:
    """Store a row of pictures: for each coat the walk and `FORMS`. Returns the coats' names."""
    surface = load(measured)
    materials = encoded(surface)
    light = sphere.exposed(sphere.own_environments()[0])
    pictures = []
    for coats in COATS.values():

        def walked(wi: np.ndarray, wo: np.ndarray, coats: list = coats) -> np.ndarray:
            if not coats:
                return 0.5 * (surface.f(wi, wo) + surface.f(wo, wi))
            walks = {"walks": SPHERE_WALKS, "seed": SEED, "progress": False}
            return urushi.simulate(stack(surface, coats), wi, wo, **walks)[0]

        for f in (walked, *(layered(m, coats).f for m in materials.values())):
            pictures += sphere.render(f, [light])
    results.write_pictures(picture_file(measured.name), {"spheres": np.stack(pictures)})
    return list(COATS)


if __name__ == "__main__":
    main()
