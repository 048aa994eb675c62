"""Draws figure 7 from results.json and spheres.png, and prints its table.

python -m figures.figure_7.plot
"""

import json

from figures import results, style
from figures.figure_7.compute import FOLDER, PLUGINS, REFERENCE, picture_file


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    materials = found["materials"]
    picture = style.figure(8.6, 6.9)
    axes = picture.subplots(len(PLUGINS) + 1, len(materials))
    for column, (material, methods) in enumerate(materials.items()):
        axes[0, column].set_title(material, fontsize=9)
        spheres = results.shown_pictures(picture_file(material))["spheres"]
        for row, name in enumerate([*PLUGINS, "reference"]):
            axis = axes[row, column]
            axis.imshow(spheres[row])
            axis.set(xticks=[], yticks=[])
            if column == 0:
                axis.set_ylabel(ROWS[name], fontsize=9)
            axis.set_xlabel(caption(methods, name), fontsize=8)
    style.save(picture, FOLDER / "figure.png")
    print("\n".join(table(found)))


def caption(methods, name: str) -> str:
    """The error and the samples of a picture."""
    if name not in methods:
        return f"{REFERENCE} samples"
    method = methods[name]
    return f"error {method['error']:.2g}\n{method['samples']} samples"


def table(found) -> list[str]:
    """Lines of a Markdown table: one for each material."""
    names = list(PLUGINS)
    lines = [
        "| material | "
        + " | ".join(f"time, {name}" for name in names if name != "networks")
        + " | "
        + " | ".join(f"error, {name}" for name in names)
        + " | "
        + " | ".join(f"bias, {name}" for name in names if name != "walk")
        + " |",
    ]
    lines.append("|---" * (3 * len(names) - 1) + "|")
    for material, methods in found["materials"].items():
        cells = [material.replace("\n", " ")]
        cells += [f"{methods[name]['time']:.2g}" for name in names if name != "networks"]
        cells += [f"{methods[name]['error']:.2g}" for name in names]
        cells += [f"{methods[name]['bias']:.2g}" for name in names if name != "walk"]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


#: Labels of the rows.
ROWS = {
    "Belcour 2018": "Belcour 2018,\nequal time",
    "walk": "walk,\nequal time",
    "networks": "networks",
    "reference": "walk,\nconverged",
}


if __name__ == "__main__":
    main()
