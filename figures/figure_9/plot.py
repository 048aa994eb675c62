"""Draws figure 9 from results.json and the pictures, and prints its table.

python -m figures.figure_9.plot
"""

import json

import numpy as np

from figures import results, style
from figures.figure_9.compute import COATS, FOLDER, SHOWN, materials, picture_file

#: Kinds of files in the table.
PLURALS = {"RGL": "RGL files", "stand-in": "stand-ins"}


def main() -> None:
    """Draw the figure and print the table."""
    if not materials():
        return  # compute.py has said so
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(7.6, 8.6)
    axes = picture.subplots(len(found["shown"]), 2 * len(COATS))
    for row, name in zip(axes, found["shown"], strict=True):
        draw(row, name, found["materials"][name])
    for column, coats in enumerate(COATS):
        for axis, label in zip(
            axes[0, 2 * column :], ("walk" if column else "file", "networks"), strict=False
        ):
            axis.set_title(f"{coats},\n{label}", fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n".join(table(found)))


def draw(axes, name: str, material) -> None:
    """A row: for each coat the walk and the networks, with E."""
    pictures = results.shown_pictures(picture_file(name))["spheres"]
    for column, axis in enumerate(axes):
        axis.imshow(pictures[column])
        axis.set(xticks=[], yticks=[])
        if column % 2:
            e = material["E"][list(COATS)[column // 2]]
            axis.set_xlabel(f"E {100 * e:.2g} %", fontsize=8)
    axes[0].set_ylabel(f"{name}\n({material['file']})", fontsize=7)


def table(found) -> list[str]:
    """Lines of a Markdown table: E of the drawn materials, and means and medians of all."""
    lines = ["| material | " + " | ".join(COATS) + " |", "|---" * (1 + len(COATS)) + "|"]
    rows = {}
    for name, share in zip(found["shown"], SHOWN, strict=True):
        place = {0: "best", 1: "worst"}.get(share, f"{100 * share:.0f} % are better")
        material = found["materials"][name]
        rows[f"{name}, {material['file']}: {place}"] = material["E"]
    for kind in PLURALS:
        members = [m for m in found["materials"].values() if m["file"] == kind]
        for label, mean in (("mean", np.mean), ("median", np.median)):
            values = {name: mean([m["E"][name] for m in members]) for name in COATS}
            rows[f"{label} of {len(members)} {PLURALS[kind]}"] = values
    every = found["materials"].values()
    rows["the walk's own error"] = {
        name: np.mean([m["noise"][name] for m in every]) for name in COATS
    }
    for label, values in rows.items():
        cells = " | ".join(f"{100 * value:.2g} %" for value in values.values())
        lines.append(f"| {label} | {cells} |")
    return lines


if __name__ == "__main__":
    main()
