"""Forty coated materials and white furnaces: models and renderers against the walk.

adobe/openpbr-bsdf takes part if URUSHI_OPENPBR_PROGRAM names a program (`methods.program`), and
Cycles if BPY_PYTHON names a Python that has Blender's module bpy. Others are always there. The
references are kept in out/referee.
"""

import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks import conformance
from benchmarks.experiment import NETWORKS, Experiment, Found, Options
from benchmarks.referee import materials, methods
from benchmarks.showing import percent, rounded, table

import urushi
from urushi.files import atomic_write

#: Walks of a pair, and of a reference, with its own seed.
WALKS, SEED = 1 << 11, 1
FOLDER, TRUTH = Path("out/referee"), "walk"


@cache
def truth(name: str, walks: int) -> tuple[np.ndarray, np.ndarray]:
    """f and its standard error, float32 (N, 3), of a material at `materials.pairs`."""
    path = FOLDER / f"{name.replace(' ', '_')}-{walks}.npz"
    wi, wo = materials.pairs()
    if not path.is_file():
        stack = materials.STACKS[name]
        f, se = urushi.simulate(stack, wi, wo, walks=walks, seed=SEED, progress=False)
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary, temporary.open("wb") as file:
            np.savez(file, f=f, se=se)
    with np.load(path) as stored:
        return stored["f"], stored["se"]


def measure(name: str, options: Options) -> dict[str, Any]:
    """Errors by material, albedos of white materials, and the price; or why there are none."""
    wi, wo = materials.pairs()
    walks = options.count(WALKS, 2)
    chosen = list(materials.STACKS)[:: max(1, round(1 / options.share))]
    if name == TRUTH:
        own = (truth(x, walks) for x in chosen)
        e = [conformance.channel_errors(f + np.sqrt(2 / np.pi) * se, f, wi, wo) for f, se in own]
        return {"noise": {x: float(f"{v.mean():.3g}") for x, v in zip(chosen, e, strict=True)}}
    method = methods.METHODS[name]
    try:
        stacks = {x: materials.STACKS[x] for x in chosen}
        values = methods.evaluated(method, stacks, walks, wi, wo)
        white = methods.furnace(method, walks)
        price = methods.price(method)
    except (subprocess.CalledProcessError, OSError) as error:
        return {"missing": str(error)}
    errors, albedos = {}, {}
    for x, f in values.items():
        reference = truth(x, walks)[0]
        errors[x] = float(f"{conformance.channel_errors(f, reference, wi, wo).mean():.4g}")
        ratio = f.mean(0, dtype=np.float64) / reference.mean(0, dtype=np.float64)
        albedos[x] = float(f"{(ratio - 1).mean():.4g}")
    return {
        "E": errors,
        "albedo": albedos,
        "furnace": {x: rounded(row) for x, row in white.items()},
        "price": None if price is None else float(f"{1e9 * price:.3g}"),
    }


def tables(found: Found) -> list[str]:
    """All methods; E by family; and what is missing."""
    lines, families, missing = [], [], []
    for name, own in found.items():
        if "missing" in own:
            missing.append([name, own["missing"]])
        if "E" not in own:
            continue
        e, albedo = np.array(list(own["E"].values())), np.abs(list(own["albedo"].values()))
        white = np.array(list(own["furnace"].values()))
        limits = [f"{x:.2f}" for x in (white.min(), white.max())] if len(white) else ["–", "–"]
        price = "–" if own["price"] is None else f"{own['price']:.0f}"
        shares = [percent(x) for x in (e.mean(), np.percentile(e, 95), albedo.mean())]
        lines.append([name, f"{len(e)}", *shares, *limits, price])
        cells = []
        for family, members in materials.MATERIALS.items():
            part = [own["E"][f"{family}, {x}"] for x in members if f"{family}, {x}" in own["E"]]
            cells.append(f"{percent(np.mean(part))} ({len(part)})" if part else "–")
        families.append([name, *cells])
    head = ["method", "materials", "E mean", "p95", "error of the albedo"]
    made = []
    if lines:
        made.append(table([*head, "white: least", "most", "price [ns]"], lines))
        made.append(table(["E (materials)", *materials.MATERIALS], families))
    if missing:
        made.append(table(["not measured", "why"], missing))
    return made


EXPERIMENT = Experiment(
    cases=lambda _: {name: name for name in (TRUTH, *methods.METHODS)},
    measure=measure,
    tables=tables,
    pages=("docs/referee.md",),
    models=NETWORKS,
    minutes=25,
)
