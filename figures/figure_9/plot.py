"""Draws figure 9 from results.json and the pictures, and prints its table.

python -m figures.figure_9.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.figure_9.compute import COATS, FOLDER, FORMS, SHOWN, materials, picture_file

#: Kinds of files in the table.
PLURALS = {"RGL": "RGL files", "stand-in": "stand-ins"}


def main() -> None:
    """Draw the figure and print the table."""
    if not materials():
        return  # compute.py has said so
    found = json.loads((FOLDER / "results.json").read_text())
    forms = 1 + len(FORMS)
    picture = style.figure(11, 8.6)
    axes = picture.subplots(len(found["shown"]), forms * len(COATS))
    for row, name in zip(axes, found["shown"], strict=True):
        draw(row, name, found["materials"][name])
    for column, coats in enumerate(COATS):
        labels = ("walk" if column else "file", *FORMS)
        for axis, label in zip(axes[0, forms * column :], labels, strict=False):
            axis.set_title(f"{coats},\n{label}", fontsize=7)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(axes, name: str, material) -> None:
    """A row: for each coat the walk, and codes and tables with E."""
    pictures = results.shown_pictures(picture_file(name))["spheres"]
    places = iter(axes)
    for column, axis in enumerate(axes):
        axis.imshow(pictures[column])
        axis.set(xticks=[], yticks=[])
    for coats in COATS:
        next(places)
        for form in FORMS:
            next(places).set_xlabel(f"E {100 * material[form][coats]:.2g} %", fontsize=8)
    axes[0].set_ylabel(f"{name}\n({material['file']})", fontsize=7)


def tables(found) -> list[str]:
    """A table: E of the drawn materials, and means and medians of all."""
    columns = [(coats, form) for coats in COATS for form in FORMS]
    rows = {}
    for name, share in zip(found["shown"], SHOWN, strict=True):
        place = {0: "best", 1: "worst"}.get(share, f"{100 * share:.0f} % are better")
        material = found["materials"][name]
        rows[f"{name}, {material['file']}: {place}"] = [material[f][c] for c, f in columns]
    for kind in PLURALS:
        members = [m for m in found["materials"].values() if m["file"] == kind]
        for label, mean in (("mean", np.mean), ("median", np.median)):
            values = [mean([m[form][coats] for m in members]) for coats, form in columns]
            rows[f"{label} of {len(members)} {PLURALS[kind]}"] = values
    every = found["materials"].values()
    rows["the walk's own error"] = [
        np.mean([m["noise"][coats] for m in every]) for coats, _ in columns
    ]
    return [
        page.table(
            ["material", *map(": ".join, columns)],
            [[label, *(f"{100 * e:.2g} %" for e in values)] for label, values in rows.items()],
        )
    ]


if __name__ == "__main__":
    main()
