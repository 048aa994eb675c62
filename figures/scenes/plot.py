"""Draws the figure from results.json and the pictures of compute.py, and prints its tables.

python -m figures.scenes.plot
"""

import json

from matplotlib.patches import Rectangle

from figures import page, results, style
from figures.scenes.compute import CASES, FOLDER, METHODS, PARTS

#: Insets of each case: column and row of the upper left pixel, in pixels of the picture.
INSETS = {
    "still-life": ((60, 52), (150, 92)),
    "globe": ((85, 40), (95, 132)),
    "teapot": ((85, 70), (140, 60)),
    "brushed": ((60, 45), (140, 95)),
    "shoe": ((140, 70), (70, 60)),
    "shoe-1": ((140, 70), (70, 60)),
    "shoe-point": ((140, 70), (70, 60)),
}
SIDE = 40
#: Colours of the insets' frames.
FRAMES = ("#56b4e9", "#f0e442")


def main() -> None:
    """Draw the figure and print the tables."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(9, 8.8)
    panels = picture.subfigures((len(CASES) + 1) // 2, 2).ravel()
    for part, name in zip(panels, CASES, strict=False):
        draw(part, name, found["scenes"][name])
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def draw(part, name: str, found) -> None:
    """The picture of the networks, and insets of the walk, the networks and the reference."""
    case = CASES[name]
    shown = results.shown_pictures(PARTS / f"{name}.npz")
    axes = part.subplot_mosaic("pabc;pdef", width_ratios=(2.75, 1, 1, 1))
    time = "equal time" if case.equal_time else "one sample per pixel"
    part.suptitle(f"{case.title}; {time}", fontsize=8)
    for axis in axes.values():
        axis.set(xticks=[], yticks=[])
    axes["p"].imshow(shown["networks"])
    axes["p"].set_xlabel("networks", fontsize=8)
    for row, ((x, y), colour) in enumerate(zip(INSETS[name], FRAMES, strict=True)):
        frame = {"edgecolor": colour, "linewidth": 1.2, "facecolor": "none"}
        axes["p"].add_patch(Rectangle((x - 0.5, y - 0.5), SIDE, SIDE, **frame))
        for column, method in enumerate((*METHODS, "reference")):
            axis = axes["abcdef"[3 * row + column]]
            axis.imshow(shown[method][y : y + SIDE, x : x + SIDE], interpolation="nearest")
            for spine in axis.spines.values():
                spine.set(color=colour, linewidth=1.2)
            if row == 0:
                axis.set_title(method, fontsize=8, pad=3)
            elif method in found:
                axis.set_xlabel(caption(found[method]), fontsize=6.5)


def caption(found) -> str:
    """Samples and errors of one picture."""
    samples = f"{found['samples']} sample{'s' if found['samples'] > 1 else ''}"
    return f"{samples}\nrel. MSE {found['relative_mse']:.2g}\nFLIP {found['flip']:.2g}"


def tables(found) -> list[str]:
    """Tables: the scenes at equal time, and at one sample per pixel."""
    return [_equal_time(found), _one_sample(found)]


def _equal_time(found) -> str:
    head = ["scene", "samples: walk", "networks", "relative MSE: walk", "networks", "ratio"]
    rows = []
    for name, part in _parts(found, equal_time=True):
        walk, networks = part["walk"], part["networks"]
        cells = [CASES[name].title, f"{walk['samples']}", f"{networks['samples']}"]
        cells += [f"{x['relative_mse']:.2g}" for x in (walk, networks)]
        cells.append(f"{walk['relative_mse'] / networks['relative_mse']:.1f}")
        cells += [f"{x['flip']:.2g}" for x in (walk, networks)]
        rows.append(cells)
    return page.table([*head, "FLIP: walk", "networks"], rows)


def _one_sample(found) -> str:
    rows = []
    for name, part in _parts(found, equal_time=False):
        both = part["walk"], part["networks"]
        cells = [f"{x[key]:.2g}" for key in ("relative_mse", "flip") for x in both]
        rows.append([CASES[name].title, *cells])
    return page.table(["scene", "relative MSE: walk", "networks", "FLIP: walk", "networks"], rows)


def _parts(found, equal_time: bool):
    return [(n, p) for n, p in found["scenes"].items() if CASES[n].equal_time == equal_time]


if __name__ == "__main__":
    main()
