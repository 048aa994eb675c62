"""Errors, laws and costs of all methods that render layered materials, on the same work.

    python -m figures.verdict.compute

Errors are those of held-out stacks of the paper's Table 2 against the walk. Costs are CPU times of
renders of a sphere over those with Mitsuba's `principled`, by turns in one process.
"""

import functools
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.scenes import processor
from benchmarks.speed import render

import urushi
from figures import results
from urushi.data.distribution import Table2
from urushi.eval import predict, samples
from urushi.eval.groups import Group
from urushi.nets.weights import DEFAULT, default_model
from urushi.reference.stack import Stack
from urushi.rivals import belcour, weidlich

FOLDER = Path(__file__).parent
PARTS = Path("out/figures/verdict")
#: Numbers of interfaces, stacks of each, and the seed of stacks and walks; other than figure 8's.
INTERFACES, STACKS, SEED = (2, 3), 32, 23
#: Methods, and their plugins.
PLUGINS = {
    "principled": "principled",
    "networks": DEFAULT,
    "walk": "layered",
    "Belcour 2018": "layered_belcour",
    "Weidlich and Wilkie 2007": "layered_weidlich",
}
RIVALS = {"Belcour 2018": belcour, "Weidlich and Wilkie 2007": weidlich}
#: White stacks: widths of the coat, and cosines at which their albedo is measured, by directions.
WIDTHS, COSINES, DIRECTIONS = (0.1, 0.3, 0.6), (0.1, 0.3, 0.6, 1.0), 1 << 14
#: The picture's width, samples of a pixel, and turns of renders.
SIDE, SAMPLES, TURNS = 256, 32, 3


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    parts: dict[str, Any] = {
        f"interfaces_{n}": functools.partial(errors, n, STACKS) for n in INTERFACES
    }
    parts |= {"laws": laws, "costs": costs}
    found = results.collect(PARTS, parts)
    head = {"weights": default_model().fingerprint, "processor": processor()}
    results.write(FOLDER / "results.json", {**head, **found})


def errors(interfaces: int, stacks: int) -> dict[str, Any]:
    """E of each method and the reference's own error, of each stack; and its reciprocity.

    A method's `exchange` is E between its values and those with wi and wo exchanged.
    """
    group = Group(f"verdict, {interfaces} interfaces", Table2(interfaces - 1), stacks)
    held_out = samples.simulate(group, SEED)
    materials = predict.materials(default_model(), held_out)
    row = np.repeat(np.arange(stacks, dtype=np.uint32), held_out.wi.shape[1])
    found: dict[str, Any] = {}
    for name in ("networks", *RIVALS):
        both = []
        for wi, wo in ((held_out.wi, held_out.wo), (held_out.wo, held_out.wi)):
            if name == "networks":
                both.append(predict.evaluate(materials, wi, wo))
            else:
                flat = wi.reshape(-1, 3), wo.reshape(-1, 3)
                both.append(RIVALS[name].rows(held_out.table, row, *flat).reshape(wi.shape[:2]))
        weight = held_out.wi[..., 2] * held_out.wo[..., 2]
        exchange = (np.abs(both[0] - both[1]) * weight).sum() / (both[0] * weight).sum()
        found[name] = results.rounded(samples.stack_errors(both[0], held_out))
        found[f"{name}, exchange"] = float(f"{exchange:.3g}")
    found["walk"] = results.rounded(samples.reference_error(held_out)[0])
    return found


def laws() -> dict[str, float]:
    """The largest albedo of each method over white coated stacks, which reflect at most 1."""
    rng = np.random.default_rng(SEED)
    radius, turn = np.sqrt(rng.uniform(size=DIRECTIONS)), rng.uniform(0, 2 * np.pi, DIRECTIONS)
    wo = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)
    found = dict.fromkeys(("networks", *RIVALS), 0.0)
    for alpha in WIDTHS:
        for bottom in (urushi.diffuse(1.0), urushi.conductor(alpha=alpha, r0=1.0)):
            stack: Stack = urushi.coat(bottom, alpha, 1.5)
            material = urushi.layer(urushi.dielectric(alpha=alpha, eta=1.5), bottom)
            methods = {"networks": material.f} | {
                name: functools.partial(rival.f, stack) for name, rival in RIVALS.items()
            }
            for cosine in COSINES:
                wi = np.tile([np.sqrt(1 - cosine**2), 0, cosine], (DIRECTIONS, 1))
                for name, f in methods.items():
                    # Directions have cosine density: the albedo is pi times the mean of f.
                    found[name] = max(found[name], float(np.pi * f(wi, wo)[:, 0].mean()))
    return {name: float(f"{albedo:.4g}") for name, albedo in found.items()}


def costs() -> dict[str, dict[str, float]]:
    """CPU time of a render over that with `principled`, constant and textured."""
    found: dict[str, dict[str, float]] = {}
    for kind in ("constant", "textured"):
        scenes = {}
        for name, plugin in PLUGINS.items():
            rival = plugin in ("layered_belcour", "layered_weidlich")
            bsdf = render.material("layered" if rival else plugin, kind == "textured")
            scenes[name] = render.scene([bsdf | {"type": plugin} if rival else bsdf], SIDE)
        times: dict[str, list[float]] = {name: [] for name in scenes}
        for turn in range(TURNS + 1):
            for name, scene in scenes.items():
                cpu = render.rendered(scene, SAMPLES, turn)[1]
                if turn > 0:  # the first one compiles
                    times[name].append(cpu)
        least = {name: min(values) for name, values in times.items()}
        found[kind] = {name: round(least[name] / least["principled"], 3) for name in least}
    return found


if __name__ == "__main__":
    main()
