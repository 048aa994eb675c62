"""Errors, laws and costs of all methods that render layered materials, on the same work.

The system of Fan et al. (2022) has the weights `PAPER`, of two commands that `docs/published.md`
names; URUSHI_PAPER_WEIGHTS names others, such as the authors' (`python -m fan2022 import`). E over
measured bottoms needs the folder that URUSHI_TEST_DATA names.
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
from benchmarks.verdict import costs, fits
from benchmarks.verdict import methods as known
from fan2022 import PaperNetworks

PAPER = os.environ.get(
    "URUSHI_PAPER_WEIGHTS", str(Path(known.__file__).with_name("fan2022.safetensors"))
)
INTERFACES = (1, 2, 3, 4, 5, 6)
#: CPU seconds of each method in a scene.
SECONDS = 2.5
#: The methods in the order of rows; that of `PAPER` needs a weights file. Markers and colours, and
#: what methods have by construction: bottoms; anisotropy, textures, and gradients with respect to
#: all parameters; and languages of real-time shaders.
METHODS = {
    known.NETWORKS: (
        *("o", COLOURS["networks"]),
        "any BSDF | anisotropy, textures, gradients | GLSL, HLSL, WGSL, OSL",
    ),
    known.PAPER: ("^", COLOURS["Fan et al. 2022"], "any BRDF | textures | –"),
    known.WALK: ("s", COLOURS["walk"], "any BSDF | anisotropy, textures | –"),
    known.BOTH_WAYS: ("*", "#777777", "any BRDF | anisotropy | –"),
    known.BELCOUR: ("D", COLOURS["Belcour 2018"], "conductors and diffuse | textures | –"),
    known.WEIDLICH: ("v", COLOURS["exact"], "any BSDF | anisotropy, textures | –"),
    fits.PRINCIPLED: (
        *("P", COLOURS["principled"]),
        "its own | anisotropy, textures, gradients | in most renderers",
    ),
    fits.RECIPE: ("<", "#56b4e9", "its own | anisotropy, textures | MaterialX"),
    fits.GGX: ("X", "#8c6d1f", "any, by a fit | – | –"),
    fits.NBRDF: (">", "#7b3294", "any, by training | – | –"),
}
#: Walks of a pair at both ends of the walk's line.
WALKS = 1, 1 << 14
NONE = "–"


def cases(options: Options) -> dict[str, Any]:
    """The functions that measure, by name."""
    paper = PaperNetworks.read(PAPER)
    found: Found = {
        "evaluations": partial(costs.evaluations, PAPER),
        "renders": partial(costs.renders, PAPER),
        "memory": costs.memory,
        "new": partial(costs.new_materials, paper),
        **{f"interfaces_{n}": partial(known.isotropic, n, paper) for n in INTERFACES},
        "laws": partial(known.laws, paper),
    }
    archives = [path for path in options.data() if path.suffix == ".npz"]
    if archives:
        found["measured"] = partial(known.measured, archives[0], paper)
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
    """E of two interfaces over the cost of an evaluation, and over the number of interfaces.

    That of the walk is a line over the cost of more and more walks.
    """
    picture = figure(10, 4.6)
    left, right = picture.subplots(1, 2, sharey=True)
    for name in rows(found):
        marker, colour, _ = METHODS[name]
        look = {"marker": marker, "color": colour}
        cost, e = cost_of(found["evaluations"], name), percent(found, name, 2)
        if cost is not None and e is not None:
            if name in known.ESTIMATORS:
                count = np.array(WALKS)
                line = e[0] * np.sqrt(known.WALKS / count)
                left.plot(cost * count, line, color=colour, linewidth=1)
                cost *= known.WALKS
            left.errorbar(
                cost, e[0], yerr=np.abs(np.array(e[1:]) - e[0])[:, None], capsize=3, **look
            )
        points = [(n, e[0]) for n in INTERFACES if (e := percent(found, name, n)) and e[0] > 1e-2]
        label = name + (f", {known.WALKS:,} walks" if name in known.ESTIMATORS else "")
        right.plot(*np.transpose(points), linewidth=1, markersize=5, label=label, **look)
    left.set(xscale="log", yscale="log", ylabel="E [%]")
    left.set_title("two interfaces", fontsize=10)
    left.set_xlabel("cost of an evaluation, over that of principled")
    right.set_xlabel("interfaces")
    for axis in (left, right):
        axis.grid(alpha=0.3)
    handles, labels = right.get_legend_handles_labels()
    picture.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return picture


def rows(found: Found) -> list[str]:
    """The methods that were measured."""
    return [name for name in METHODS if name in found["interfaces_2"]]


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
    made = []
    if whole:
        head = ["method", "bottoms", "features", "shaders"]
        properties = table(head, [[name, METHODS[name][2]] for name in rows(found)])
        made += [error_table(found), properties]
    if whole and {"evaluations", "renders", "memory", "new", "laws"} <= found.keys():
        made.append(cost_table(found))
    return [*made, lights(found)] if views(Options()).keys() <= found.keys() else made


def error_table(found: Found) -> str:
    """E by number of interfaces, and over measured bottoms; of all stacks and of the fits'."""
    first, *others = INTERFACES

    def line(name: str, label: str, stacks: int | None = None) -> list[str]:
        parts = [found[f"interfaces_{n}"].get(name) for n in INTERFACES]
        e = [part and part["E"][:stacks] for part in parts]
        e.append(None if stacks else found.get("measured", {}).get(name))
        return [label, *(shown(x and 100 * float(np.mean(x))) for x in e)]

    lines = []
    for name in rows(found):
        if name == fits.PRINCIPLED:  # the first fit
            lines.append(line(known.NETWORKS, "networks, the stacks of the fits", known.FITTED))
        lines.append(line(name, name))
        if name == known.NETWORKS:
            lines.append(line(known.TABLES, known.TABLES))
    head = ["method", f"{first} interface", *map(str, others), "measured bottoms"]
    return table(head, lines)


def cost_table(found: Found) -> str:
    """Laws, costs and memory."""
    head = ["not reciprocal", "largest albedo", "an evaluation", "a render", "textured"]
    head += ["material [B]", "texel [B]", "six interfaces [B]", "new material [s]"]
    lines = []
    for name in rows(found):
        by_number = [found[f"interfaces_{n}"] for n in INTERFACES]
        measured = [part[name] for part in by_number if name in part]
        exchange = max(part["exchange"] for part in measured)
        walked, memory = name in known.ESTIMATORS, found["memory"].get(name, {})
        fit = float(np.mean([part["seconds"] for part in measured]))
        cells = ["0" if walked or exchange < 1e-5 else f"{100 * exchange:.2g} %"]
        cells += [f"{found['laws'][known.WALK if walked else name]:.2f}"]
        parts = found["evaluations"], *found["renders"].values()
        cells += [shown(cost_of(part, name)) for part in parts]
        cells += [f"{memory.get(key) or NONE}" for key in ("material", "texel", "texel 6")]
        lines.append([name, *cells, f"{found['new'].get(name, fit):.2g}"])
    return table(["method", *head], lines)


def lights(found: Found) -> str:
    """The walk's mean squared error over that of each method, by scene and light."""
    lines = []
    for name in (*METHODS, "exact"):
        parts = [[found[f"{scene}, {light}"].get(name) for light in LIGHTS] for scene in SCENES]
        if parts[0][0] is not None:
            lines.append([name, *(" / ".join(shown(x) for x in part) for part in parts)])
    labels = " / ".join(LABELS[light] for light in LIGHTS)
    return table(["method", *(f"{scene}: {labels}" for scene in SCENES)], lines)


def shown(value: float | None) -> str:
    """Two digits; a dash for nothing."""
    if value is None:
        return NONE
    return "0" if value < 1e-3 else f"{value:.2g}" if value < 100 else f"{value:.0f}"


EXPERIMENT = Experiment(
    cases=cases,
    tables=tables,
    measure=lambda case, _: case(),
    plot=plot,
    models=BOTH | {"paper weights": lambda: PaperNetworks.read(PAPER)},
    minutes=45,
)
