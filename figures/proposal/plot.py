"""Draws the figure from results.json and the pictures, and prints its table.

python -m figures.proposal.plot
"""

import json

import numpy as np
from benchmarks.quality.sampling import ANGLES

from figures import page, results, style
from figures.proposal.compute import COLUMNS, COUNTS, FOLDER, PICTURE, SHARES

#: Colours of the proposals, and of their names in the figure.
COLOURS = {
    COLUMNS[0]: style.COLOURS["Belcour 2018"],
    COLUMNS[1]: style.COLOURS["Fan et al. 2022"],
    COLUMNS[2]: style.COLOURS["networks"],
}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(10.4, 6.4)
    left, right = picture.subfigures(1, 2, width_ratios=(1.75, 1))
    draw_spheres(left, found["spheres"])
    draw_variation(right, found["variation"])
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw_spheres(part, found) -> None:
    """A row for each material and number of samples, a column for each proposal."""
    pictures = results.shown_pictures(PICTURE)["spheres"]
    rows = [(name, count) for name in found for count in COUNTS]
    axes = part.subplots(len(rows), len(COLUMNS))
    for row, (name, count) in enumerate(rows):
        for column, proposal in enumerate(COLUMNS):
            axis = axes[row, column]
            axis.imshow(pictures[row, column])
            axis.set(xticks=[], yticks=[])
            if row == 0:
                axis.set_title(proposal.replace(", ", ",\n"), fontsize=9)
            if column == 0:
                lines = (*name.split(", "), f"{count} samples")
                axis.set_ylabel(",\n".join(lines), fontsize=8)
            value = found[name].get(proposal, {}).get(str(count))
            axis.set_xlabel("" if value is None else f"error {value:.2g}", fontsize=8)


def draw_variation(part, found) -> None:
    """The variation over the share of materials and angles, and over the angle."""
    top, below = part.subplots(2, 1)
    for name, values in found.items():
        top.plot(values["quantiles"], 100 * SHARES, color=COLOURS[name], label=name)
        median, high = values["by angle"]
        below.plot(ANGLES, median, color=COLOURS[name])
        below.plot(ANGLES, high, color=COLOURS[name], linestyle="--")
    top.set(xscale="log", xlim=(0.03, 100), ylabel="materials and angles [%]")
    top.set_xlabel("variation of f cos θo / pdf")
    top.legend(fontsize=8)
    below.set(yscale="log", ylim=(0.03, 200), xlabel="θi [degrees]", xticks=(0, 30, 60, 85))
    below.set_ylabel("variation: median; 95 % dashed")
    for axis in (top, below):
        axis.grid(alpha=0.3)


def tables(found) -> list[str]:
    """A table with a row for each proposal."""
    head = ["proposal", "median", "95 %", "worst", "largest weight"]
    head += [f"{name}, {count} samples" for name in found["spheres"] for count in COUNTS]
    rows = []
    for name, values in found["variation"].items():
        quantiles = np.interp((0.5, 0.95, 1), SHARES, values["quantiles"])
        cells = [name, *map(number, (*quantiles, values["largest"]))]
        cells += [
            number(errors[name][str(count)])
            for errors in found["spheres"].values()
            for count in COUNTS
        ]
        rows.append(cells)
    return [page.table(head, rows)]


def number(value: float) -> str:
    """Two significant digits without an exponent."""
    return f"{value:,.2g}" if value < 100 else f"{float(f'{value:.2g}'):,.0f}"


if __name__ == "__main__":
    main()
