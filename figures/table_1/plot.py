"""Draws the figure from results.json, and prints its tables.

python -m figures.table_1.plot
"""

import json
import math
from typing import Any

import numpy as np
from benchmarks.rivals import metalayer, nbrdf, rainer

from figures import page, results, style
from figures.table_1.compute import FOLDER, METHODS
from urushi.fan2022 import architecture as paper
from urushi.nets.weights import default_model

#: Errors in the order of the tables: name, factor and unit.
ERRORS = {"E": (100, " %"), "P": (100, " %"), "L1": (1e3, "e-3")}
HEADS = {"E": "E", "P": "P", "L1": "L1 [1/sr]"}
#: Texels of a 4K texture, and bytes of a number.
TEXELS, BYTES = 4096**2, 4
#: What the paper says of a method: sharp highlights are kept, and how a material is represented.
PAPER = {
    "Rainer 2019": ("no", "train a new en/decoder"),
    "Rainer 2020": ("no", "run the encoder"),
    "NBRDF": ("yes", "train a new decoder"),
    "Fan 2022": ("yes", "optimise the code, 10 to 45 s on a GPU"),
}


def main() -> None:
    """Draw the figure and print the tables."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(8.4, 3.4)
    axes = picture.subplots(1, 2, sharey=True)
    for axis, name in zip(axes, ("E", "P"), strict=True):
        draw(axis, name, found)
    axes[0].set(ylabel="error [%]", title="E: reflected energy")
    axes[1].set(title="P: highlights and dark directions")
    handles, labels = axes[0].get_legend_handles_labels()
    picture.legend(handles, labels, loc="outside lower center", ncols=6, fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(axis, name: str, found) -> None:
    """Means of one error with their intervals, by group and method."""
    colours = ("#d55e00", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#0072b2")
    groups = list(found["groups"])
    for place, (method, colour) in enumerate(zip(measured(found), colours, strict=False)):
        values = [errors(found, group, method, name) for group in groups]
        means = np.array([v.mean() for v in values])
        spread = np.abs(np.array([results.interval(v) for v in values]).T - means)
        x = np.arange(len(groups)) + 0.13 * (place - 2.5)
        axis.errorbar(
            x, means, spread, marker="o", ms=4, ls="", capsize=2, color=colour, label=method
        )
    axis.set_xticks(np.arange(len(groups)), groups, fontsize=8)
    axis.set(yscale="log")
    axis.grid(axis="y", alpha=0.3)


def measured(found: dict[str, Any]) -> list[str]:
    """The methods that all materials have results of."""
    first, *others = found["materials"].values()
    return [m for m in first if m != "reference" and all(m in one for one in others)]


def errors(found: dict[str, Any], group: str, method: str, name: str) -> np.ndarray:
    """An error of a method for each material of a group, in the unit of the tables."""
    materials = (found["materials"][n] for n in found["groups"][group])
    return ERRORS[name][0] * np.array([material[method][name] for material in materials])


def storage() -> dict[str, tuple[int, int, str]]:
    """Numbers of a texel, of a decoder, and what one decoder serves, by method."""
    decoders = {
        latent: rainer.size(rainer.initial(np.random.default_rng(0), rainer.decoder_sizes(latent)))
        for latent in (rainer.LATENT_2019, rainer.LATENT_2020)
    }
    common, own_numbers = metalayer.size(metalayer.initial(np.random.default_rng(0)))
    own = default_model()
    evaluation = sum(map(math.prod, paper.shapes(paper.EVALUATION).values()))
    return {
        "Rainer 2019": (rainer.LATENT_2019, decoders[rainer.LATENT_2019], "a texture"),
        "Rainer 2020": (rainer.LATENT_2020, decoders[rainer.LATENT_2020], "all"),
        "NBRDF": (nbrdf.SIZE, 0, "a BRDF"),
        "BSDFNet": (own_numbers, common, "all; here a BRDF"),
        "Fan 2022": (3 * paper.LATENT, evaluation, "all"),
        "Urushi": (3 * own.arch.latent, own.params["basis.rows"].size, "all"),
    }


def seconds(found: dict[str, Any], method: str) -> str:
    """Median CPU time to represent a material of exact values."""
    values = [m[method]["seconds"] for m in found["materials"].values() if "seconds" in m[method]]
    median = float(np.median(values))
    return f"{median:.2g} s" if median > 0.1 else f"{1000 * median:.2g} ms"


def short(value: float) -> str:
    """Two significant digits without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def tables(found: dict[str, Any]) -> list[str]:
    """Tables: storage and times, then each error by method and group."""
    return [_costs(found), *(_errors(found, name) for name in ERRORS)]


def _costs(found: dict[str, Any]) -> str:
    head = ["method", "numbers per texel", "per decoder", "one decoder for", "4K texture"]
    head += ["to represent", "to evaluate", "paper: keeps highlights", "paper: for a new material"]
    rows = []
    for method, (texel, decoder, serves) in storage().items():
        if method in METHODS and method not in measured(found):
            continue
        size = BYTES * (TEXELS * texel + decoder) / 1e9
        cells = [method, f"{texel}", f"{decoder:,}", serves, f"{size:.2g} GB"]
        if method == "Fan 2022":
            cells += ["", ""]
        elif method == "Urushi":
            cells += [seconds(found, "Urushi, encoded"), f"{found['evaluation'][method]:.2g} µs"]
        else:
            cells += [seconds(found, method), f"{found['evaluation'][method]:.2g} µs"]
        rows.append([*cells, *PAPER.get(method, ("", ""))])
    return page.table(head, rows)


def _errors(found: dict[str, Any], name: str) -> str:
    groups, (factor, unit) = found["groups"], ERRORS[name]
    rows = []
    for method in measured(found):
        cells = [method]
        for group in groups:
            values = errors(found, group, method, name)
            low, high = results.interval(values)
            cells.append(f"{short(values.mean())}{unit} ({short(low)} to {short(high)})")
        rows.append(cells)
    if name == "E":
        own = [
            factor * np.mean([found["materials"][n]["reference"] for n in members])
            for members in groups.values()
        ]
        cells = [f"{short(value)}{unit}" if value else "0" for value in own]
        rows.append(["the reference's noise", *cells])
    heads = [f"{group} ({len(members)})" for group, members in groups.items()]
    return page.table([HEADS[name], *heads], rows)


if __name__ == "__main__":
    main()
