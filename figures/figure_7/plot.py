"""Draws figure 7 from results.json and spheres.png, and prints its table.

python -m figures.figure_7.plot
"""

import json

from figures import page, results, style
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
    print("\n\n".join(tables(found)))


def caption(methods, name: str) -> str:
    """The error and the samples of a picture."""
    if name not in methods:
        return f"{REFERENCE} samples"
    method = methods[name]
    return f"error {method['error']:.2g}\n{method['samples']} samples"


def tables(found) -> list[str]:
    """A table with a row for each material."""
    columns = [("time", name) for name in PLUGINS if name != "networks"]
    columns += [("error", name) for name in PLUGINS]
    columns += [("bias", name) for name in PLUGINS if name != "walk"]
    rows = [
        [material.replace("\n", " "), *(f"{methods[name][key]:.2g}" for key, name in columns)]
        for material, methods in found["materials"].items()
    ]
    return [page.table(["material", *map(", ".join, columns)], rows)]


#: Labels of the rows.
ROWS = {
    "Belcour 2018": "Belcour 2018,\nequal time",
    "walk": "walk,\nequal time",
    "networks": "networks",
    "reference": "walk,\nconverged",
}


if __name__ == "__main__":
    main()
