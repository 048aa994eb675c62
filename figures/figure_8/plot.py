"""Draws figure 8 from results.json, and prints its table.

python -m figures.figure_8.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.figure_8.compute import FOLDER, INCIDENT, INTERFACES, OUTGOING


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10, 5.6)
    axes = picture.subplots(2, 3).ravel()
    draw_errors(axes[0], found)
    draw_lobes(axes[1:], found["lobes"])
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw_errors(axis, found) -> None:
    """Mean E over the number of interfaces, with bootstrap intervals, on a logarithmic axis."""
    for shift, (name, label) in zip((-0.08, 0, 0.08), METHODS.items(), strict=True):
        values = [100 * np.array(found[f"interfaces_{n}"][name]) for n in INTERFACES]
        means = np.array([e.mean() for e in values])
        bounds = np.array([results.interval(e) for e in values]).T
        axis.errorbar(
            np.array(INTERFACES) + shift,
            means,
            yerr=np.abs(bounds - means),
            color=style.COLOURS[name],
            marker="o",
            markersize=4,
            capsize=3,
            label=label,
        )
    axis.set(yscale="log", xlabel="interfaces", ylabel="E, mean over stacks [%]", ylim=(0.1, 200))
    axis.set_xticks(INTERFACES)
    axis.legend(fontsize=8, loc="center", bbox_to_anchor=(0.5, 0.6))
    axis.grid(axis="y", alpha=0.3)
    axis.set_title(f"{len(found['interfaces_2']['networks'])} stacks each", fontsize=10)


def draw_lobes(axes, lobes) -> None:
    """f cos θo over the angle in the plane of incidence, a panel for each number of interfaces."""
    top = 2 * max(map(max, lobes["walk"]))
    for axis, interfaces, walk, networks in zip(
        axes, INTERFACES, lobes["walk"], lobes["networks"], strict=True
    ):
        reference, ours = style.COLOURS["reference"], style.COLOURS["networks"]
        axis.plot(OUTGOING, walk, color=reference, linewidth=4, alpha=0.3, label="walk")
        axis.plot(OUTGOING, networks, color=ours, linewidth=1.2, label="networks")
        axis.set(yscale="log", ylim=(1e-3, top), xticks=[-90, -45, 0, 45, 90])
        axis.set(xlabel="θo [degrees]", ylabel="f cos θo [1/sr]")
        axis.grid(alpha=0.3)
        axis.set_title(f"gold, {interfaces} interfaces, θi = {INCIDENT:g}°", fontsize=10)
    axes[0].legend(fontsize=8, loc="upper left")


def tables(found) -> list[str]:
    """A table: mean E with its interval."""
    rows = []
    for n in INTERFACES:
        cells = [f"{n}"]
        for name in METHODS:
            e = 100 * np.array(found[f"interfaces_{n}"][name])
            low, high = results.interval(e)
            cells.append(f"{e.mean():.2g} % ({low:.2g} to {high:.2g})")
        rows.append(cells)
    return [page.table(["interfaces", *METHODS.values()], rows)]


#: Methods in the order of the table, with their labels.
METHODS = {
    "networks": "networks",
    "Belcour 2018": "Belcour 2018",
    "reference": "the reference's own error",
}


if __name__ == "__main__":
    main()
