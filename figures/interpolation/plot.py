"""Draws the figure from results.json and the spheres of compute.py, and prints its table.

python -m figures.interpolation.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.interpolation.compute import ENDS, FOLDER, METHODS, PARTS, REFERENCE, SHARES, SIZE

#: Labels of the rows.
LABELS = {
    "lerp": "urushi.lerp",
    "linear in the codes": "linear in\nthe codes",
    "parameters": "parameters\n(walk)",
    REFERENCE: "BRDFs\n(walk)",
}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(11, 3.6)
    axes = picture.subplots(1, len(ENDS), sharey=True)
    for axis, name in zip(axes, ENDS, strict=True):
        draw(axis, name, found["ways"][name])
    picture.suptitle("Ways from one coated metal to another, E against the blend of BRDFs", size=10)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(axis, name: str, found) -> None:
    """The spheres of one way: methods by rows, shares by columns; E between the ends."""
    shown = results.shown_pictures(PARTS / f"{name}.npz")
    rows = [np.concatenate(list(shown[method]), axis=1) for method in LABELS]
    axis.imshow(np.concatenate(rows), interpolation="lanczos")
    middle = (np.arange(len(SHARES)) + 0.5) * SIZE
    axis.set_xticks(middle, [f"{share:g}" for share in SHARES], fontsize=8)
    axis.set_yticks((np.arange(len(LABELS)) + 0.5) * SIZE, list(LABELS.values()), fontsize=8)
    axis.tick_params(length=0)
    axis.set_xlabel("share of the second material", fontsize=8)
    axis.set_title(name, fontsize=9)
    for row, method in enumerate(METHODS):
        for column in range(1, len(SHARES) - 1):
            axis.text(
                (column + 0.5) * SIZE,
                (row + 0.97) * SIZE,
                f"E {100 * found[method]['E'][column]:.2g} %",
                color="white",
                fontsize=5.5,
                ha="center",
                va="bottom",
            )


def tables(found) -> list[str]:
    """A table: E between the ends, and the light halfway, of each way."""
    head = ["materials differ in", "reference's own error"]
    for method in METHODS:
        head += [f"{method}: mean E", "light halfway"]
    rows = []
    for name, way in found["ways"].items():
        cells = [name, f"{100 * np.mean(way['noise']):.2g} %"]
        for method in METHODS:
            halfway = way[method]["light"][SHARES.index(0.5)]
            cells.append(f"{100 * np.mean(way[method]['E'][1:-1]):.2g} %")
            cells.append(f"{100 * halfway:+.2g} %".replace("-", "−"))
        rows.append(cells)
    return [page.table(head, rows)]


if __name__ == "__main__":
    main()
