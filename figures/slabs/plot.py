"""Draws the shares of six slabs from results.json, and prints their table.

python -m figures.slabs.plot
"""

import json

import numpy as np

from figures import page, style
from figures.slabs.compute import ANGLES, FOLDER, SHOWN, SLABS, SMOOTH, closed

#: Labels and colours of the two shares.
SHARES = (("reflected", style.COLOURS["principled"]), ("transmitted", style.COLOURS["networks"]))


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10, 6)
    for axis, (name, slab) in zip(picture.subplots(2, 3).ravel(), SLABS.items(), strict=True):
        for number, (label, colour) in enumerate(SHARES):
            walk, table = (found[name][kind][number] for kind in ("walk", "tables"))
            axis.plot(ANGLES, walk, "o", color=colour, markersize=4, label=f"{label}, walk")
            axis.plot(ANGLES, table, "-", color=colour, label=f"{label}, table")
            if name in SMOOTH:
                fine = np.linspace(0, 89, 90)
                share = closed(slab[1], slab[3], fine)[number]
                axis.plot(fine, share, ":", color="#000000", label="closed form")
        axis.set(ylim=(0, 1), xlabel="angle of incidence [°]", title=name)
        axis.grid(alpha=0.3)
        if name == SMOOTH[0]:
            axis.legend(fontsize=7)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def tables(found) -> list[str]:
    """A table: reflected and transmitted share by walk and table, at a few angles."""
    head = ["slab", *(f"{angle}°: walk; table" for angle in SHOWN)]
    rows = []
    for name in SLABS:
        cells = [name]
        for angle in SHOWN:
            at = ANGLES.index(angle)
            pairs = (
                " + ".join(f"{100 * share[at]:.1f}" for share in found[name][kind])
                for kind in ("walk", "tables")
            )
            cells.append("; ".join(pairs) + " %")
        rows.append(cells)
    return [page.table(head, rows)]


if __name__ == "__main__":
    main()
