"""Forty coated materials and white furnaces: models and renderers against the walk.

adobe/openpbr-bsdf takes part if URUSHI_OPENPBR_PROGRAM names a program (`methods.program`), and
Cycles if BPY_PYTHON names a Python that has Blender's module bpy. Others are always there. The
references are kept.
"""

import subprocess
from functools import cache, partial
from typing import Any

import numpy as np
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, kept
from benchmarks.measures import channel_errors, coat_errors, moved
from benchmarks.referee import materials, methods
from benchmarks.showing import table

import urushi

#: Walks of a pair of the references, their seed, and walks of methods that walk.
WALKS, SEED, OWN_WALKS = 1 << 9, 1, 1 << 7
#: Largest width of coats that lose little light by scattering it once.
SMOOTH = 0.1
TRUTH = "noise of the references"


@cache
def truth(name: str, walks: int) -> list[np.ndarray]:
    """f and its standard error, float32 (N, 3), of a material at `materials.pairs`."""
    stack = materials.STACKS[name]
    walked = partial(urushi.simulate, stack, *materials.pairs(), seed=SEED, progress=False)
    return kept(f"referee/{name.replace(' ', '_')}-{walks}", partial(walked, walks=walks))


def measure(name: str, options: Options) -> dict[str, Any]:
    """Errors by material, albedos of white materials, and the price; or why there are none."""
    wi, wo = materials.pairs()
    walks = options.count(WALKS, 2)
    chosen = list(materials.STACKS)[:: max(1, round(1 / options.share))]
    if name == TRUTH:
        own = (truth(x, walks) for x in chosen)
        e = [channel_errors(moved(f, se), f, wi, wo) for f, se in own]
        return {"E": {x: v.mean() for x, v in zip(chosen, e, strict=True)}}
    method = methods.METHODS[name]
    try:
        own_walks = options.count(OWN_WALKS, 2)
        values = methods.evaluated(method, {x: materials.STACKS[x] for x in chosen}, own_walks)
        white = methods.furnace(method, own_walks)
        price = methods.price(method)
    except (subprocess.CalledProcessError, OSError) as error:
        return {"missing": str(error)}
    errors, albedos = {}, {}
    for x, f in values.items():
        errors[x], albedos[x] = coat_errors(f, truth(x, walks)[0], wi, wo)
    return {"E": errors, "albedo": albedos, "furnace": white, "price": price}


def tables(found: Found) -> list[str]:
    """All methods; E by family; and what is missing."""
    lines, families, missing = [], [], []
    simple = {x: sum(map(methods.simple, own.values())) for x, own in materials.MATERIALS.items()}
    for name, own in found.items():
        if "missing" in own:
            missing.append([name, own["missing"]])
            continue
        e = np.array(list(own["E"].values()))
        smooth = [
            x for name, x in own["E"].items() if materials.STACKS[name].coats[0].alpha <= SMOOTH
        ]
        parts = (e.mean(), np.percentile(e, 95), np.mean(smooth) if smooth else 0.0)
        shares = [f"{100 * x:.1f}" for x in parts]
        others = ["–"] * 4
        if "furnace" in own:
            others[0] = f"{100 * np.mean(np.abs(list(own['albedo'].values()))):.1f}"
            if white := [x for row in own["furnace"].values() for x in row]:
                others[1:3] = f"{min(white):.2f}", f"{max(white):.2f}"
            if own["price"] is not None:
                others[3] = f"{own['price']:.0f}"
        lines.append([name, f"{len(e)}", *shares, *others])
        cells = []
        for family, members in materials.MATERIALS.items():
            part = [own["E"][f"{family}, {x}"] for x in members if f"{family}, {x}" in own["E"]]
            usual = len(members), simple[family]
            some = "" if len(part) in usual else f" ({len(part)})"
            cells.append(f"{100 * np.mean(part):.1f}{some}" if part else "–")
        families.append([name, *cells])
    head = ["method", "materials", "E [%]: mean", "p95", "smooth coats", "albedo [%]"]
    heads = [f"{x} ({len(own)}; {simple[x]})" for x, own in materials.MATERIALS.items()]
    parts = (
        ([*head, "white: least", "most", "price [ns]"], lines),
        (["E [%] (materials; simple ones)", *heads], families),
        (["not measured", "why"], missing),
    )
    return [table(*part) for part in parts if part[1]]


EXPERIMENT = Experiment(
    lambda _: {name: name for name in (TRUTH, *methods.METHODS)},
    tables,
    measure,
    pages=("docs/referee.md",),
    models=NETWORKS,
    minutes=25,
)
