"""Draws the figure from results.json, and prints its tables.

python -m figures.verdict.plot
"""

import json
from typing import Any

import numpy as np
from benchmarks.scenes import LIGHTS

from figures import page, results, style
from figures.light.compute import SCENES
from figures.light.plot import LABELS
from figures.verdict import fits
from figures.verdict import methods as known
from figures.verdict.compute import FOLDER, INTERFACES
from figures.verdict.costs import PRINCIPLED
from figures.verdict.errors import FITTED

#: What methods have by construction: noise, bottoms, anisotropy, textures, gradients with respect
#: to all parameters, and languages of real-time shaders.
HAVE = {
    known.NETWORKS: "no | any BSDF | yes | yes | yes | GLSL, HLSL, WGSL, OSL",
    known.PAPER: "no | any BRDF | no | yes | no | no",
    known.WALK: "yes | any BSDF | yes | yes | no | no",
    known.BOTH_WAYS: "yes | any BRDF | yes | no | no | no",
    known.BELCOUR: "no | conductors and diffuse | no | yes | no | no",
    known.WEIER: "no | conductors and diffuse | yes | no | no | no",
    known.WEIDLICH: "no | any BSDF | yes | yes | no | no",
    fits.PRINCIPLED: "no | its own | yes | yes | yes | in most renderers",
    fits.RECIPE: "no | its own | yes | yes | no | MaterialX",
    fits.GGX: "no | any, by a fit | no | no | no | no",
    fits.NBRDF: "no | any, by training | no | no | no | no",
}
#: Markers of methods, and colours where those of `style` are not enough.
MARKERS = dict(zip(known.METHODS, "o^s*D1vP<X>", strict=True))
COLOURS = {
    known.NETWORKS: style.COLOURS["networks"],
    known.PAPER: style.COLOURS["Fan et al. 2022"],
    known.WALK: style.COLOURS["reference"],
    known.BOTH_WAYS: "#777777",
    known.BELCOUR: style.COLOURS["Belcour 2018"],
    known.WEIER: "#7f2704",
    known.WEIDLICH: style.COLOURS["exact"],
    fits.PRINCIPLED: style.COLOURS["principled"],
    fits.RECIPE: "#56b4e9",
    fits.GGX: "#8c6d1f",
    fits.NBRDF: "#7b3294",
}
#: Walks of a pair at both ends of the walk's line.
WALKS = 1, 1 << 14
NONE = "–"
SAME = "networks, the stacks of the fits"


def main() -> None:
    """Draw the figure and print the tables."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10, 4.6)
    left, right = picture.subplots(1, 2, sharey=True)
    over_cost(left, found)
    over_interfaces(right, found)
    handles, labels = right.get_legend_handles_labels()
    picture.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def over_cost(axis: Any, found: dict[str, Any]) -> None:
    """E of two interfaces over the cost of an evaluation; that of the walk for many walks."""
    for name in rows(found):
        cost, e = cost_of(found["evaluations"], name), percent(found, name, 2)
        if cost is None or e is None:
            continue
        look = {"marker": MARKERS[name], "color": COLOURS[name], "capsize": 3}
        if name in known.ESTIMATORS:
            count = np.array(WALKS)
            line = e[0] * np.sqrt(known.WALKS / count)
            axis.plot(cost * count, line, color=COLOURS[name], linewidth=1)
            cost *= known.WALKS
        axis.errorbar(cost, e[0], yerr=np.abs(np.array(e[1:]) - e[0])[:, None], **look)
    axis.set(xscale="log", yscale="log", ylabel="E [%]")
    axis.set_title("two interfaces", fontsize=10)
    axis.set_xlabel("cost of an evaluation, over that of principled")
    axis.grid(alpha=0.3)


def over_interfaces(axis: Any, found: dict[str, Any]) -> None:
    """E over the number of interfaces."""
    for name in rows(found):
        points = [(n, e[0]) for n in INTERFACES if (e := percent(found, name, n)) and e[0] > 1e-2]
        label = name + (f", {known.WALKS:,} walks" if name in known.ESTIMATORS else "")
        look = {"marker": MARKERS[name], "color": COLOURS[name], "label": label}
        axis.plot(*np.transpose(points), linewidth=1, markersize=5, **look)
    axis.set_xlabel("interfaces")
    axis.grid(alpha=0.3)


def rows(found: dict[str, Any]) -> list[str]:
    """The methods that were measured."""
    return [name for name in known.METHODS if name in found["interfaces_2"]]


def cost_of(part: dict[str, float], name: str) -> float | None:
    """A cost over that of `principled`; None if it was not measured."""
    return part.get(PRINCIPLED if name == fits.PRINCIPLED else name)


def percent(found: dict[str, Any], name: str, interfaces: int) -> tuple[float, ...] | None:
    """The mean of E, and the ends of its interval [%]."""
    part = found[f"interfaces_{interfaces}"].get(name)
    if part is None:
        return None
    e = 100 * np.array(part["E"])
    return (float(e.mean()), *results.interval(e))


def tables(found: dict[str, Any]) -> list[str]:
    """Tables: errors, laws and costs, renders at equal time, and properties."""
    return [errors(found), costs(found), lights(found), properties(found)]


def errors(found: dict[str, Any]) -> str:
    """E by number of interfaces, with anisotropy, and over measured bottoms."""
    first, *others = INTERFACES
    head = [f"{first} interface", *(str(n) for n in others)]
    head += ["coat of two widths", "bottom of two", "measured bottoms"]
    lines = []
    for name in rows(found):
        if name == fits.PRINCIPLED:  # the first fit
            lines.append([SAME, *same_stacks(found)])
        lines.append([name, *error_cells(found, name)])
        if name == known.NETWORKS:
            lines.append([known.TABLES, *error_cells(found, known.TABLES)])
    return page.table(["method", *head], lines)


def error_cells(found: dict[str, Any], name: str) -> list[str]:
    """E of a method in all columns."""
    cells = [shown(e and e[0]) for n in INTERFACES for e in [percent(found, name, n)]]
    for part in ("anisotropic_coat", "anisotropic_bottom", "measured"):
        e = found.get(part, {}).get(name)
        cells.append(shown(None if e is None else 100 * float(np.mean(e))))
    return cells


def same_stacks(found: dict[str, Any]) -> list[str]:
    """E of the networks for the stacks that models are fitted to."""
    parts = [found[f"interfaces_{n}"][known.NETWORKS]["E"] for n in INTERFACES]
    parts += [found[f"anisotropic_{surface}"][known.NETWORKS] for surface in ("coat", "bottom")]
    cells = [shown(100 * float(np.mean(e[:FITTED]))) for e in parts]
    return [*cells, NONE]


def costs(found: dict[str, Any]) -> str:
    """Laws, costs and memory."""
    head = ["not reciprocal", "largest albedo", "an evaluation", "a render", "textured"]
    head += ["material [B]", "texel [B]", "six interfaces [B]", "new material [s]"]
    lines = []
    for name in rows(found):
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
    return page.table(["method", *head], lines)


def lights(found: dict[str, Any]) -> str:
    """The walk's mean squared error over that of each method, by scene and light."""
    lines = []
    for name in (*rows(found), "exact"):
        parts = [[found[f"{scene}, {light}"].get(name) for light in LIGHTS] for scene in SCENES]
        if parts[0][0] is not None:
            lines.append([name, *(" / ".join(shown(x) for x in part) for part in parts)])
    labels = " / ".join(LABELS[light] for light in LIGHTS)
    return page.table(["method", *(f"{scene}: {labels}" for scene in SCENES)], lines)


def properties(found: dict[str, Any]) -> str:
    """What methods have by construction."""
    head = ["method", "noise", "bottoms", "anisotropy", "textures", "gradients", "shaders"]
    return page.table(head, [[name, HAVE[name]] for name in rows(found)])


def shown(value: float | None) -> str:
    """Two digits; a dash for nothing."""
    if value is None:
        return NONE
    return "0" if value < 1e-3 else f"{value:.2g}" if value < 100 else f"{value:.0f}"


if __name__ == "__main__":
    main()
