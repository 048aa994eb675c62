"""Errors, laws and costs of all methods that render layered materials, on the same work.

The system of Fan et al. (2022) has the weights `PAPER`, of `python -m fan2022 train --scale 8e-4`,
3 hours 34 minutes; URUSHI_PAPER_WEIGHTS names others, such as the authors' (`python -m fan2022
import`). In their training and here, the projection's learning rate was 1e-3 in all steps; it has
since been lowered step by step, like the authors'. E over measured bottoms needs the folder that
URUSHI_TEST_DATA names.
"""

import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.experiment import BOTH, Experiment, Found, Options, Pictures
from benchmarks.experiments.equal_time import LABELS, SAMPLES, SCENES, gain
from benchmarks.experiments.equal_time import cases as views
from benchmarks.pictures import View, at_equal_time
from benchmarks.scenes import LIGHTS, PRINCIPLED, WALK
from benchmarks.scenes import PAPER as PREFIX
from benchmarks.showing import COLOURS, figure, interval, table
from benchmarks.verdict import costs, errors, fits
from benchmarks.verdict import methods as known
from benchmarks.verdict.errors import FITTED
from fan2022 import PaperNetworks

PAPER = os.environ.get(
    "URUSHI_PAPER_WEIGHTS", str(Path(known.__file__).with_name("fan2022.safetensors"))
)
INTERFACES = (1, 2, 3, 4, 5, 6)
#: CPU seconds of each method in a scene.
SECONDS = 2.5
#: What methods have by construction: bottoms; anisotropy, textures, and gradients with respect to
#: all parameters; and languages of real-time shaders.
HAVE = {
    known.NETWORKS: "any BSDF | anisotropy, textures, gradients | GLSL, HLSL, WGSL, OSL",
    known.PAPER: "any BRDF | textures | –",
    known.WALK: "any BSDF | anisotropy, textures | –",
    known.BOTH_WAYS: "any BRDF | anisotropy | –",
    known.BELCOUR: "conductors and diffuse | textures | –",
    known.WEIER: "conductors and diffuse | anisotropy | –",
    known.WEIDLICH: "any BSDF | anisotropy, textures | –",
    fits.PRINCIPLED: "its own | anisotropy, textures, gradients | in most renderers",
    fits.RECIPE: "its own | anisotropy, textures | MaterialX",
    fits.GGX: "any, by a fit | – | –",
    fits.NBRDF: "any, by training | – | –",
}
#: Markers of methods, and colours where those of `style` are not enough.
MARKERS = dict(zip(known.METHODS, "o^s*D1vP<X>", strict=True))
LOOKS = {
    known.NETWORKS: COLOURS["networks"],
    known.PAPER: COLOURS["Fan et al. 2022"],
    known.WALK: COLOURS["walk"],
    known.BOTH_WAYS: "#777777",
    known.BELCOUR: COLOURS["Belcour 2018"],
    known.WEIER: "#7f2704",
    known.WEIDLICH: COLOURS["exact"],
    fits.PRINCIPLED: COLOURS["principled"],
    fits.RECIPE: "#56b4e9",
    fits.GGX: "#8c6d1f",
    fits.NBRDF: "#7b3294",
}
#: Walks of a pair at both ends of the walk's line.
WALKS = 1, 1 << 14
NONE = "–"
SAME = "networks, the stacks of the fits"


def cases(options: Options) -> dict[str, Any]:
    """The functions that measure, by name."""
    paper = PaperNetworks.read(PAPER)
    found: Found = {
        "evaluations": partial(costs.evaluations, PAPER),
        "renders": partial(costs.renders, PAPER),
        "memory": costs.memory,
        "new": partial(costs.new_materials, paper),
        **{f"interfaces_{n}": partial(errors.isotropic, n, paper) for n in INTERFACES},
        "laws": partial(errors.laws, paper),
    }
    archives = [path for path in options.data() if path.suffix == ".npz"]
    if archives:
        found["measured"] = partial(errors.measured, archives[0], paper)
    return found | {name: partial(equal_time, view) for name, view in views(options).items()}


def equal_time(view: View) -> dict[str, float]:
    """The walk's mean squared error over that of each method at the walk's time.

    The error is that against the walk's converged picture: variance and bias. `exact` is a BSDF
    without noise and bias at the cost of Mitsuba's `principled`.
    """
    plugins = {name: plugin for name, plugin in known.PLUGINS.items() if name != known.WALK}
    plugins[known.PAPER] = PREFIX + PAPER
    names = WALK, PRINCIPLED, *plugins.values()
    methods, reference = at_equal_time(view, names, SAMPLES, SECONDS)
    walk, cheap, own = (methods[name] for name in (WALK, PRINCIPLED, plugins[known.NETWORKS]))
    return {"exact": gain(walk, own, 0.0, cheap.second)} | {
        name: gain(walk, methods[plugin], methods[plugin].bias(reference))
        for name, plugin in plugins.items()
    }


def plot(found: Found, _: Pictures) -> Any:
    """E over the cost of an evaluation, and over the number of interfaces."""
    picture = figure(10, 4.6)
    left, right = picture.subplots(1, 2, sharey=True)
    over_cost(left, found)
    over_interfaces(right, found)
    handles, labels = right.get_legend_handles_labels()
    picture.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return picture


def over_cost(axis: Any, found: Found) -> None:
    """E of two interfaces over the cost of an evaluation; that of the walk for many walks."""
    for name in rows(found):
        cost, e = cost_of(found["evaluations"], name), percent(found, name, 2)
        if cost is None or e is None:
            continue
        look = {"marker": MARKERS[name], "color": LOOKS[name], "capsize": 3}
        if name in known.ESTIMATORS:
            count = np.array(WALKS)
            line = e[0] * np.sqrt(known.WALKS / count)
            axis.plot(cost * count, line, color=LOOKS[name], linewidth=1)
            cost *= known.WALKS
        axis.errorbar(cost, e[0], yerr=np.abs(np.array(e[1:]) - e[0])[:, None], **look)
    axis.set(xscale="log", yscale="log", ylabel="E [%]")
    axis.set_title("two interfaces", fontsize=10)
    axis.set_xlabel("cost of an evaluation, over that of principled")
    axis.grid(alpha=0.3)


def over_interfaces(axis: Any, found: Found) -> None:
    """E over the number of interfaces."""
    for name in rows(found):
        points = [(n, e[0]) for n in INTERFACES if (e := percent(found, name, n)) and e[0] > 1e-2]
        label = name + (f", {known.WALKS:,} walks" if name in known.ESTIMATORS else "")
        look = {"marker": MARKERS[name], "color": LOOKS[name], "label": label}
        axis.plot(*np.transpose(points), linewidth=1, markersize=5, **look)
    axis.set_xlabel("interfaces")
    axis.grid(alpha=0.3)


def rows(found: Found) -> list[str]:
    """The methods that were measured."""
    return [name for name in known.METHODS if name in found["interfaces_2"]]


def apart(found: Found) -> list[str]:
    """Those with figures of their own: for one width, Weier and Belcour 2020 is Belcour 2018."""
    return [name for name in rows(found) if name != known.WEIER]


def cost_of(part: dict[str, float], name: str) -> float | None:
    """A cost over that of `principled`; None if it was not measured."""
    return part.get(PRINCIPLED if name == fits.PRINCIPLED else name)


def percent(found: Found, name: str, interfaces: int) -> tuple[float, ...] | None:
    """The mean of E, and the ends of its interval [%]."""
    part = found[f"interfaces_{interfaces}"].get(name)
    if part is None:
        return None
    e = 100 * np.array(part["E"])
    return (float(e.mean()), *interval(e))


def tables(found: Found) -> list[str]:
    """Tables: errors, laws and costs, renders at equal time, and properties, of what is there."""
    whole = all(f"interfaces_{n}" in found for n in INTERFACES)
    made = [error_table(found), properties(found)] if whole else []
    if whole and {"evaluations", "renders", "memory", "new", "laws"} <= found.keys():
        made.append(cost_table(found))
    return [*made, lights(found)] if views(Options()).keys() <= found.keys() else made


def error_table(found: Found) -> str:
    """E by number of interfaces, and over measured bottoms."""
    first, *others = INTERFACES
    head = [f"{first} interface", *(str(n) for n in others)]
    head += ["measured bottoms"]
    lines = []
    for name in apart(found):
        if name == fits.PRINCIPLED:  # the first fit
            lines.append([SAME, *same_stacks(found)])
        lines.append([name, *error_cells(found, name)])
        if name == known.NETWORKS:
            lines.append([known.TABLES, *error_cells(found, known.TABLES)])
    return table(["method", *head], lines)


def error_cells(found: Found, name: str) -> list[str]:
    """E of a method in all columns."""
    cells = [shown(e and e[0]) for n in INTERFACES for e in [percent(found, name, n)]]
    e = found.get("measured", {}).get(name)
    return [*cells, shown(None if e is None else 100 * float(np.mean(e)))]


def same_stacks(found: Found) -> list[str]:
    """E of the networks for the stacks that models are fitted to."""
    parts = [found[f"interfaces_{n}"][known.NETWORKS]["E"] for n in INTERFACES]
    cells = [shown(100 * float(np.mean(e[:FITTED]))) for e in parts]
    return [*cells, NONE]


def cost_table(found: Found) -> str:
    """Laws, costs and memory."""
    head = ["not reciprocal", "largest albedo", "an evaluation", "a render", "textured"]
    head += ["material [B]", "texel [B]", "six interfaces [B]", "new material [s]"]
    lines = []
    for name in apart(found):
        by_number = [found[f"interfaces_{n}"] for n in INTERFACES]
        measured = [part[name] for part in by_number if name in part]
        exchange = max(part["exchange"] for part in measured)
        walked = name in known.ESTIMATORS
        memory = found["memory"].get(name, {})
        fit = np.mean([part["seconds"] for part in measured])
        own = found["new"].get(name, float(fit))
        lines.append(
            [
                name,
                "0" if walked or exchange < 1e-5 else f"{100 * exchange:.2g} %",
                f"{found['laws'][known.WALK if walked else name]:.2f}",
                *(
                    shown(cost_of(part, name))
                    for part in (found["evaluations"], *found["renders"].values())
                ),
                *(f"{memory.get(key) or NONE}" for key in ("material", "texel", "texel 6")),
                f"{own:.2g}",
            ]
        )
    return table(["method", *head], lines)


def lights(found: Found) -> str:
    """The walk's mean squared error over that of each method, by scene and light."""
    lines = []
    for name in (*known.METHODS, "exact"):
        parts = [[found[f"{scene}, {light}"].get(name) for light in LIGHTS] for scene in SCENES]
        if parts[0][0] is not None:
            lines.append([name, *(" / ".join(shown(x) for x in part) for part in parts)])
    labels = " / ".join(LABELS[light] for light in LIGHTS)
    return table(["method", *(f"{scene}: {labels}" for scene in SCENES)], lines)


def properties(found: Found) -> str:
    """What methods have by construction."""
    head = ["method", "bottoms", "features", "shaders"]
    return table(head, [[name, HAVE[name]] for name in rows(found)])


def shown(value: float | None) -> str:
    """Two digits; a dash for nothing."""
    if value is None:
        return NONE
    return "0" if value < 1e-3 else f"{value:.2g}" if value < 100 else f"{value:.0f}"


EXPERIMENT = Experiment(
    cases=cases,
    measure=lambda case, _: case(),
    tables=tables,
    plot=plot,
    models=BOTH | {"paper weights": lambda: PaperNetworks.read(PAPER)},
    minutes=45,
)
