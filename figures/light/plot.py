"""Draws the figure from results.json, and prints its table.

python -m figures.light.plot
"""

import json

import numpy as np
from benchmarks.scenes import LIGHTS

from figures import page, style
from figures.light.compute import COUNT, FOLDER, SCENES

#: Names of the lights.
LABELS = {"own": "studio", "point": "point light", "sky": "sun and sky"}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(9, 3.6)
    axes = picture.subplots(1, len(SCENES), sharey=True)
    for axis, scene in zip(axes, SCENES, strict=True):
        draw(axis, scene, found["parts"])
    axes[0].set_ylabel(f"times less error than the walk's,\nat its {COUNT} samples per pixel")
    handles, labels = axes[0].get_legend_handles_labels()
    picture.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(axis, scene: str, parts) -> None:
    """Bars of the networks and of the exact BSDF for each light of a scene."""
    places = np.arange(len(LIGHTS))
    labels = {"networks": "networks", "exact": "exact, at the cost of principled"}
    for shift, (name, label) in zip((-0.2, 0.2), labels.items(), strict=True):
        values = [parts[f"{scene}, {light}"][name] for light in LIGHTS]
        axis.bar(places + shift, values, 0.38, color=style.COLOURS[name], label=label)
        for place, value in zip(places + shift, values, strict=True):
            axis.text(place, value, f"{value:.1f}", ha="center", va="bottom", fontsize=8)
    axis.axhline(1, color=style.COLOURS["reference"], linewidth=1)
    axis.set_xticks(places, [LABELS[light] for light in LIGHTS], fontsize=8)
    axis.set_title(scene, fontsize=10)
    axis.margins(y=0.12)


def tables(found) -> list[str]:
    """A table with a row for each scene and light."""
    columns = ("time", "variance", "networks", "exact")
    rows = []
    for name, part in found["parts"].items():
        scene, light = name.split(", ")
        rows.append([scene, LABELS[light], *(f"{part[key]:.2g}" for key in columns)])
    return [page.table(["scene", "light", *columns], rows)]


if __name__ == "__main__":
    main()
