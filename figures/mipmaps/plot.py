"""Draws the figure from results.json and the pictures of compute.py, and prints its tables.

python -m figures.mipmaps.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.mipmaps.compute import DRAWS, FOLDER, KINDS, METHODS, PARTS, SAMPLES

#: Rows of pixels of a running mean.
RUN = 9
#: Colours of the methods.
COLOURS = {
    "no filter": style.COLOURS["Belcour 2018"],
    "averages of codes": style.COLOURS["Fan et al. 2022"],
    "Urushi": style.COLOURS["networks"],
}


def main() -> None:
    """Draw the figure and print the tables."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(9, 7)
    upper, lower = picture.subfigures(2, 1, height_ratios=(1.9, 1))
    draw_plane(upper, found["plane"])
    rows, *panels = lower.subplots(1, 1 + len(KINDS), width_ratios=(1.7, *[1] * len(KINDS)))
    draw_rows(rows, found["plane"])
    for axis, kind in zip(panels, KINDS, strict=True):
        draw_levels(axis, kind, np.array(found["levels"][kind]))
    panels[0].set_ylabel("E of a level [%]", fontsize=8)
    lower.legend(*rows.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw_plane(part, found) -> None:
    """The pictures of the plane, and the reference."""
    axes = part.subplots(2, 2).ravel()
    shown = results.shown_pictures(PARTS / "plane.npz")
    for axis, name in zip(axes, (*METHODS, "reference"), strict=True):
        axis.imshow(shown[name], interpolation="nearest")
        axis.set(xticks=[], yticks=[])
        samples = f"{SAMPLES} samples" if name == "reference" else f"{DRAWS} in the middle"
        error = f", rel. MSE {found[name]['error']:.2g}" if name in found else ""
        axis.set_title(f"{name}, {samples}{error}", fontsize=8, pad=3)


def draw_rows(axis, found) -> None:
    """Error over the rows of the picture, from the horizon down, as a running mean."""
    for name in METHODS:
        rows = 100 * np.convolve(found[name]["rows"], np.full(RUN, 1 / RUN), mode="valid")
        places = np.arange(len(rows)) + RUN // 2
        axis.semilogy(places, rows, color=COLOURS[name], label=name, linewidth=1)
    axis.set_yticks((5, 10, 20, 40), ("5", "10", "20", "40"))
    axis.minorticks_off()
    axis.set_xlabel("row of pixels below the horizon", fontsize=8)
    axis.set_ylabel("RMS error of rows [%]", fontsize=8)
    axis.tick_params(labelsize=7)


def draw_levels(axis, kind: str, errors: np.ndarray) -> None:
    """E over the level."""
    for column, name in enumerate(METHODS[1:]):
        levels = np.arange(1, len(errors) + 1)
        axis.semilogy(levels, 100 * errors[:, column], "o-", ms=3, color=COLOURS[name], label=name)
    axis.set_title(kind, fontsize=8)
    axis.set_xlabel("level", fontsize=8)
    axis.set_ylim(0.05, 60)
    axis.set_xticks(np.arange(1, len(errors) + 1))
    axis.tick_params(labelsize=7)


def tables(found) -> list[str]:
    """Tables: E of levels, and errors of the picture."""
    count = len(found["levels"][KINDS[0]])
    head = ["texture", *(f"{name}: level {n}" for name in METHODS[1:] for n in (1, count))]
    rows = []
    for kind, levels in found["levels"].items():
        cells = [f"{100 * levels[n - 1][i]:.2g} %" for i in (0, 1) for n in (1, count)]
        rows.append([kind, *cells])
    plane = []
    for name in METHODS:
        part = found["plane"][name]
        light = f"{100 * part['light']:+.2g} %".replace("-", "−")
        plane.append([name, f"{part['error']:.2g}", light])
    return [page.table(head, rows), page.table(["plane", "relative MSE", "light"], plane)]


if __name__ == "__main__":
    main()
