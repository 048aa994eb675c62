"""Draws the figure of faulty walks from results.json, and prints its table.

python -m figures.simulator_biases.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.simulator_biases.compute import (
    ALPHA,
    ALPHAS,
    COAT_ALPHA,
    DEPTHS,
    ETA,
    ETAS,
    FOLDER,
    INCIDENT,
)

#: The faults in the order of the table, with their labels and colours.
FAULTS = {
    "reverse density": ("reverse density", "#d55e00"),
    "dropped connection": ("dropped connection", "#0072b2"),
}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10, 7)
    axes = picture.subplots(2, 2)
    draw_furnace(axes[0, 0], found["furnace_alpha"], ALPHAS)
    axes[0, 0].set(xscale="log", xlabel="alpha of both surfaces")
    axes[0, 0].set_title(f"white furnace, clear coat of eta {ETA:g} over a mirror", fontsize=10)
    draw_furnace(axes[0, 1], found["furnace_eta"], ETAS)
    axes[0, 1].set(xlabel="eta of the coat", ylim=(0.9, 1.3))
    axes[0, 1].set_title(f"white furnace, alpha {ALPHA:g} of both surfaces", fontsize=10)
    draw_interior(axes[1, 0], found["interior"])
    draw_table2(axes[1, 1], found["table2"])
    for axis in axes.ravel():
        axis.grid(alpha=0.3)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw_furnace(axis, found, x) -> None:
    """Albedo of stacks without absorption; light is lost to single scattering alone."""
    axis.axhline(1, color="#999999", linewidth=0.8)
    for name, (label, colour) in {"right": ("right", "#000000"), **FAULTS}.items():
        # Standard errors are smaller than the markers.
        width = 4 if name == "right" else 1.2
        values = found[name]["albedo"]
        axis.plot(x, values, "o-", color=colour, linewidth=width, markersize=3, label=label)
    axis.set_ylabel(f"integral of f cos θo, θi = {INCIDENT:g}°")
    axis.legend(fontsize=8)


def draw_interior(axis, found) -> None:
    """Relative change of the light that was below the coat, over the bottom's width."""
    for depth, line in zip(DEPTHS, ("-", "--"), strict=True):
        part = found[f"depth {depth:g}"]
        for name, (label, colour) in FAULTS.items():
            change = 100 * interior_change(part, found["top"], name)
            medium = f"depth {depth:g}" if depth else "no medium"
            axis.plot(ALPHAS, change, line, color=colour, label=f"{label}, {medium}")
    axis.set(xscale="log", xlabel="alpha of the mirror", ylabel="change of interior light [%]")
    axis.set_title(f"mirror under a coat of alpha {COAT_ALPHA:g}", fontsize=10)
    axis.legend(fontsize=8)


def interior_change(part, top: float, name: str) -> np.ndarray:
    """Relative change of the albedo without `top`, the reflection of the coat's surface."""
    right, faulty = (np.array(part[walk]["albedo"]) for walk in ("right", name))
    return (faulty - right) / (right - top)


def draw_table2(axis, found) -> None:
    """E of the faulty values, sorted, on a logarithmic axis."""
    for name, (label, colour) in FAULTS.items():
        errors = 100 * np.sort(found[name]["E"])
        share = 100 * (np.arange(len(errors)) + 0.5) / len(errors)
        axis.plot(np.maximum(errors, 1e-3), share, color=colour, label=label)
    noise = 100 * np.mean(found["noise"])
    axis.axvline(noise, color="#999999", linestyle=":", label="right walk against stored values")
    axis.set(xscale="log", xlabel="E [%], at least 0.001", ylabel="stacks with a smaller E [%]")
    axis.set_title(f"{len(found['noise'])} stacks of Table 2", fontsize=10)
    axis.legend(fontsize=8, loc="upper left")


def tables(found) -> list[str]:
    """A table: E and the change of energy over the stacks of Table 2."""
    head = ["fault", "E, mean (95 % interval)", "median", "largest", "reflected energy, mean"]
    rows = []
    for name, (label, _) in FAULTS.items():
        errors = 100 * np.array(found["table2"][name]["E"])
        energy = 100 * np.mean(found["table2"][name]["energy"])
        low, high = results.interval(errors)
        rows.append(
            [
                label,
                f"{errors.mean():.2g} % ({low:.2g} to {high:.2g})",
                f"{np.median(errors):.2g} %",
                f"{errors.max():.2g} %",
                f"{energy:+.2g} %",
            ]
        )
    return [page.table(head, rows)]


if __name__ == "__main__":
    main()
