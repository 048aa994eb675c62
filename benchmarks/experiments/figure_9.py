"""Measured materials, bare and under coats, by codes, by tables and textured; after Figure 9.

Files of the RGL database, and published neural fits to MERL materials, whose tables stand in for
MERL's files. The reference is the walk over the measured material.
"""

import tempfile
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks import sphere
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.measures import error
from benchmarks.showing import grid, percent, table
from benchmarks.subjects import Measured, coated, materials, reciprocal

import urushi
from urushi.core import direction_sets
from urushi.errors import UrushiWarning
from urushi.material import Material
from urushi.mitsuba.reading import probing

#: Every eighth stand-in, from the fifth on; all others.
FIRST, EVERY = 4, 8
#: Coats, from the lowest to the topmost.
MILK = {"alpha": 0.1, "eta": 1.4, "albedo": (0.95, 0.85, 0.7), "sigma_t": 0.5}
CLEAR = {"alpha": 0.05, "eta": 1.5}
COATS: dict[str, list[dict[str, Any]]] = {
    "bare": [],
    "clear coat": [CLEAR],
    "milky and clear coat": [MILK, CLEAR],
}
#: Representations, and the argument `table` of `urushi.encode`; None is the default.
FORMS: dict[str, bool | None] = {"code": False, "table": None}
#: A width that varies: that of `CLEAR` is a third of the way along it.
VARYING, WIDTHS = "textured", (0.02, 0.11)
#: Materials that are drawn, in the order of the codes' E under coats.
SHOWN = (
    *("red-plastic", "white-marble", "cm_military_green_rgb", "vch_golden_yellow_rgb"),
    *("cc_green_malachite_rgb", "chm_mint_rgb"),
)
#: Pairs of directions and walks for E; walks for each node of a sphere; seed of both.
PAIRS, WALKS, SPHERE_WALKS, SEED = 300, 1 << 13, 8, 9


def cases(options: Options) -> dict[str, Measured]:
    found = materials(options.data())
    stand_ins = [m for m in found if m.kind == "stand-in"][FIRST::EVERY]
    return {m.name: m for m in (*(m for m in found if m.kind != "stand-in"), *stand_ins)}


def measure(measured: Measured, options: Options) -> Any:
    """E of each of `FORMS` by name of the coats, and the walk's own `noise` there; spheres.

    `VARYING` is a clear coat whose width varies over the material.
    """
    warnings.simplefilter("ignore", UrushiWarning)  # RGL files are not reciprocal
    surface = measured.load()
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(SEED), PAIRS)
    found: Found = {"file": measured.kind, **{name: {} for name in (*FORMS, VARYING, "noise")}}
    pictures = []
    for name, coats in COATS.items():
        ours = {form: layered(surface, coats, form, options) for form in FORMS}
        f, se = walked(surface, coats, wi, wo, options.count(WALKS, 64))
        values = {form: material.f(wi, wo) for form, material in ours.items()}
        if coats == [CLEAR]:
            values[VARYING] = textured(surface, wi, wo, options)
        # The mean size of a normal error is 0.8 of its deviation.
        for form, own in (values | {"noise": f + 0.8 * se}).items():
            found[form][name] = error(own, f, wi, wo)
        if measured.name in SHOWN:
            walk = partial(walked, surface, coats, walks=SPHERE_WALKS)
            pictures.append(sphere.studio(lambda *pair, walk=walk: walk(*pair)[0]))
            pictures += [sphere.studio(material.f) for material in ours.values()]
    return (found, {"spheres": np.stack(pictures)}) if pictures else found


def walked(surface: Any, coats: list, wi: np.ndarray, wo: np.ndarray, walks: int) -> Any:
    """f (N, 3) of the surface under coats, and its standard error."""
    if not coats:
        return reciprocal(surface)(wi, wo), np.float64(0)
    stack: Any = surface
    for coat in coats:
        stack = urushi.coat(stack, **coat)
    return urushi.simulate(stack, wi, wo, walks=walks, seed=SEED, progress=False)


def layered(surface: Any, coats: list, form: str, options: Options) -> Material:
    """The encoded surface under coats; a code if it is one."""
    material = urushi.encode(surface, options.weights, table=FORMS[form])
    for coat in coats:
        material = coated(material, coat)
        material = replace(material, table=None) if form == "code" else material
    return material


def textured(surface: Any, wi: np.ndarray, wo: np.ndarray, options: Options) -> np.ndarray:
    """f (N, 3) of `CLEAR` over the surface, at the place where its varying width is that."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "measured.safetensors"
        urushi.encode(surface, options.weights).save(path)
        ramp = mi.Bitmap(np.float32(WIDTHS).reshape(1, 2, 1))
        coat = {
            "type": "neural_layered",
            "alpha": {"type": "bitmap", "bitmap": ramp, "raw": True, "wrap_mode": "clamp"},
            "int_ior": CLEAR["eta"],
            "ext_ior": 1.0,
            "base": {"type": "neural_brdf", "filename": str(path)},
        }
        bsdf = mi.load_dict(coat)
    share = (CLEAR["alpha"] - WIDTHS[0]) / (WIDTHS[1] - WIDTHS[0])
    uv = np.tile([0.25 + 0.5 * share, 0.5], (len(wi), 1))  # between the middles of two texels
    return probing.bsdf_values(bsdf, wi.astype(np.float32), wo.astype(np.float32), uv)


def plot(found: Found, pictures: Pictures) -> Any:
    """A row for each material: for each coat the walk, and codes and tables with E."""
    columns, rows = [(coats, form) for coats in COATS for form in ("walk", *FORMS)], []
    for name in (name for name in SHOWN if name in found):
        own = found[name]
        notes = [f"E {percent(own[f][c])}" if f in FORMS else "" for c, f in columns]
        rows.append((f"{name}\n({own['file']})", pictures(name)["spheres"], notes))
    return grid((11, 8.6), [f"{coats},\n{form}" for coats, form in columns], rows)


def tables(found: Found) -> list[str]:
    """E of the drawn materials, and means and medians of all."""
    columns = [(coats, form) for coats in COATS for form in FORMS]
    columns.insert(4, ("clear coat", VARYING))

    def line(label: str, members: list[Found], mean: Any = np.mean) -> list[str]:
        values = [mean([m[form][coats] for m in members]) for coats, form in columns]
        return [label, *(f"{100 * value:.2g}" for value in values)]

    body = [line(f"{n}, {found[n]['file']}", [found[n]]) for n in SHOWN if n in found]
    for kind in dict.fromkeys(case["file"] for case in found.values()):
        members = [case for case in found.values() if case["file"] == kind]
        for label, mean in (("mean", np.mean), ("median", np.median)):
            body.append(line(f"{label} of {len(members)}, {kind}", members, mean))
    noise = [dict.fromkeys((*FORMS, VARYING), case["noise"]) for case in found.values()]
    body.append(line("the walk's own error", noise))
    return [table(["material: E [%]", *map(": ".join, columns)], body)]


EXPERIMENT = Experiment(cases, tables, measure, plot, models=NETWORKS, minutes=7)
