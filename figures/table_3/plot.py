"""Draws the figure from results.json, and prints its table.

python -m figures.table_3.plot
"""

import json

import numpy as np

from figures import page, results, style
from figures.table_3.compute import FOLDER, METHODS, SAMPLES

#: The paper's Table 3: samples per pixel and mean squared error, minutes of either method.
PAPER = {
    "still-life": {"networks": (512, 1.0e-3), "walk": (64, 2.0e-3), "minutes": 4.82},
    "globe": {"networks": (256, 9.3e-4), "walk": (24, 2.3e-3), "minutes": 2.42},
    "teapot": {"networks": (256, 6.0e-4), "walk": (12, 5.4e-3), "minutes": 0.97},
}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(7, 3.6)
    left, right = picture.subplots(1, 2)
    places = np.arange(len(SAMPLES))
    colours = {"networks": style.COLOURS["networks"], "walk": style.COLOURS["reference"]}
    for shift, name in zip((-0.12, 0.12), METHODS, strict=True):
        bars(
            left, places + shift, [found["scenes"][s][name]["mse"] for s in SAMPLES], name, colours
        )
    left.set(yscale="log", ylabel="mean squared error at equal time")
    left.legend(fontsize=8)
    ratios = [ratio_interval(found["scenes"][scene]) for scene in SAMPLES]
    for place, (middle, low, high) in zip(places, ratios, strict=True):
        spread = [[middle - low], [high - middle]]
        label = "here, two cores" if place == 0 else None
        right.errorbar(
            place, middle, spread, marker="o", capsize=3, color=colours["networks"], label=label
        )
    paper = [PAPER[scene]["walk"][1] / PAPER[scene]["networks"][1] for scene in SAMPLES]
    colour = style.COLOURS["Fan et al. 2022"]
    right.plot(places, paper, "D", color=colour, label="Fan et al. 2022, with a GPU")
    right.axhline(1, color=style.COLOURS["reference"], linewidth=1)
    right.set(ylabel="the walk's error over the networks'", ylim=(0, None))
    right.legend(fontsize=8)
    for axis in (left, right):
        axis.set_xticks(places, list(SAMPLES))
        axis.set_xlim(-0.5, len(SAMPLES) - 0.5)
        axis.grid(axis="y", alpha=0.3)
    style.save(picture, FOLDER / "figure.png")
    print("\n\n".join(tables(found)))


def bars(axis, places, errors, name: str, colours) -> None:
    """Mean errors of a method in all scenes, with their intervals."""
    means = np.array([np.mean(values) for values in errors])
    bounds = np.array([results.interval(np.array(values)) for values in errors]).T
    spread = np.abs(bounds - means)
    axis.errorbar(
        places, means, spread, marker="o", ls="", capsize=3, color=colours[name], label=name
    )


def ratio_interval(scene, seed: int = 0) -> tuple[float, float, float]:
    """The walk's mean squared error over the networks', and its bootstrap interval."""
    rng = np.random.default_rng(seed)
    means = []
    for name in ("walk", "networks"):
        values = np.array(scene[name]["mse"])
        rows = rng.integers(len(values), size=(results.RESAMPLES, len(values)))
        means.append((values.mean(), values[rows].mean(axis=1)))
    ratios = means[0][1] / means[1][1]
    low, high = np.percentile(ratios, 50 * np.array([1 - results.COVERAGE, 1 + results.COVERAGE]))
    return float(means[0][0] / means[1][0]), float(low), float(high)


def tables(found) -> list[str]:
    """A table with a row for each scene and method."""
    head = ["scene", "method", "samples", "CPU time", "mean squared error"]
    head += ["paper: samples", "error", "walk over networks", "paper"]
    rows = []
    for name in SAMPLES:
        scene = found["scenes"][name]
        for method in METHODS:
            measured, (samples, error) = scene[method], PAPER[name][method]
            mse = 1e4 * np.array(measured["mse"])
            low, high = results.interval(mse)
            cells = [name, method, f"{measured['spp']}", f"{measured['seconds']:.2g} s"]
            cells += [f"{mse.mean():.2g}e-4 ({low:.2g} to {high:.2g})", f"{samples}"]
            cells.append(f"{1e4 * error:.2g}e-4")
            if method == "networks":
                ratio, low, high = ratio_interval(scene)
                published = PAPER[name]["walk"][1] / PAPER[name]["networks"][1]
                cells += [f"{ratio:.2g} ({low:.2g} to {high:.2g})", f"{published:.2g}"]
            else:
                cells += ["", ""]
            rows.append(cells)
    return [page.table(head, rows)]


if __name__ == "__main__":
    main()
