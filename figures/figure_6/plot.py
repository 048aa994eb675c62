"""Draws figure 6 from results.json and the pictures of spheres, and prints its table.

python -m figures.figure_6.plot
"""

import json

import mitsuba as mi
import numpy as np

from figures import page, style
from figures.figure_6.compute import ALBEDOS, BOTTOMS, DEPTHS, FOLDER, SIZE, TOPS


def main() -> None:
    """Draw the figure and print the table."""
    mi.set_variant("llvm_ad_rgb")
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10, 5.2)
    axes = picture.subplots(1, 2)
    labels = (
        ("roughness", ("alpha of the gold", BOTTOMS), ("alpha of the coat", TOPS)),
        ("media", ("albedo of the medium", ALBEDOS), ("optical depth of the medium", DEPTHS)),
    )
    for axis, (name, columns, rows) in zip(axes, labels, strict=True):
        draw(axis, name, columns, rows, np.array(found[name]))
    picture.suptitle("Left half of a sphere: networks. Right half: random walk.", fontsize=10)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(axis, name: str, columns, rows, errors: np.ndarray) -> None:
    """One grid of spheres, with E of the networks below each."""
    axis.imshow(np.array(mi.Bitmap(str(FOLDER / f"{name}.png"))), interpolation="lanczos")
    middle = (np.arange(len(columns[1])) + 0.5) * SIZE
    axis.set_xticks(middle, [f"{value:g}" for value in columns[1]])
    axis.set_yticks(middle, [f"{value:g}" for value in rows[1]])
    axis.set(xlabel=columns[0], ylabel=rows[0])
    axis.tick_params(length=0)
    for (row, column), value in np.ndenumerate(errors[..., 0]):
        axis.text(
            (column + 0.5) * SIZE,
            (row + 0.975) * SIZE,
            f"E {100 * value:.2g} %",
            color="white",
            fontsize=6.5,
            ha="center",
            va="bottom",
        )


def tables(found) -> list[str]:
    """A table: mean and largest E of each grid, and the walk's own error."""
    rows = []
    for name in ("roughness", "media"):
        e, own = 100 * np.array(found[name])[..., 0], 100 * np.array(found[name])[..., 1]
        rows.append([name, *(f"{value:.2g} %" for value in (e.mean(), e.max(), own.mean()))])
    return [page.table(["grid", "mean E", "largest E", "the walk's own error"], rows)]


if __name__ == "__main__":
    main()
