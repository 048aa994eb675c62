"""Scenes by codes and by the walk, after Figures 1, 10, 11 and Table 3 of Fan et al. 2022.

The reference is the walk at many samples. At equal time, codes get as many samples as fit into the
CPU time of the walk's, which are those of Guo et al. (2018) in the paper's table.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.pictures import at_equal_time, flip
from benchmarks.scenes import BOTH, OWN, POINT, TEXTURED, WALK, View
from benchmarks.showing import figure, table
from matplotlib.patches import Rectangle

from urushi.core import error_metrics as metrics
from urushi.nets.weights import DEFAULT

#: Samples of the reference, CPU seconds of each method, and seeds of the pictures.
SAMPLES, SECONDS, SEEDS = 1024, 4.0, {"walk": 1, "networks": 2}


@dataclass(frozen=True)
class Case:
    """What is rendered, and how."""

    title: str  # of the panel
    view: View
    samples: int  # of the walk; those of codes cost the same time; 0: both take one sample
    insets: tuple[tuple[int, int], tuple[int, int]]  # column and row of their upper left pixels
    # Samples of both methods in the paper's Table 3, and their mean squared errors
    paper: dict[str, tuple[int, float]] | None = None


def _view(scene: str, light: str = OWN, depth: int = 6) -> View:
    return View(scene, light, width=240, detail=0.5, depth=depth)


STILL, SHOE = ((60, 52), (150, 92)), ((140, 70), (70, 60))
CASES = {
    "still-life": Case(
        *("still life, alpha and index textured", _view(TEXTURED), 64, STILL),
        {"walk": (64, 2.0e-3), "networks": (512, 1.0e-3)},
    ),
    "globe": Case(
        *("globe", _view("globe"), 24, ((85, 40), (95, 132))),
        {"walk": (24, 2.3e-3), "networks": (256, 9.3e-4)},
    ),
    "teapot": Case(
        *("teapot", _view("teapot"), 12, ((85, 70), (140, 60))),
        {"walk": (12, 5.4e-3), "networks": (256, 6.0e-4)},
    ),
    "brushed": Case("brushed", _view("brushed"), 16, ((60, 45), (140, 95))),
    "shoe": Case("shoe, point light and studio", _view("shoe", BOTH), 16, SHOE),
    "shoe-1": Case("shoe, point light and studio", _view("shoe", BOTH), 0, SHOE),
    "shoe-point": Case("shoe, point light alone", _view("shoe", POINT, 2), 0, SHOE),
}
#: Side of the insets [pixels], and colours of their frames.
SIDE, FRAMES = 40, ("#56b4e9", "#f0e442")


def measure(case: Case, options: Options) -> tuple[Found, dict[str, np.ndarray]]:
    """Samples per pixel, relative and plain mean squared error and FLIP of both methods.

    The reference's noise is subtracted from the squared errors, and is part of FLIP.
    """
    networks, samples = options.weights or DEFAULT, options.count(SAMPLES, 32)
    names, seconds = {"walk": WALK, "networks": networks}, options.share * SECONDS
    methods, reference = at_equal_time(case.view, list(names.values()), samples, seconds)
    speed = methods[networks].second / methods[WALK].second
    count = max(case.samples, 1)
    counts = {"walk": count, "networks": max(1, round(count / speed)) if case.samples else 1}
    images, found = {"reference": reference.image}, {}
    for name, count in counts.items():
        images[name] = methods[names[name]].render(count, SEEDS[name])[0]
        error, noise = metrics.mse(images[name], reference.image), reference.variance
        found[name] = {
            "samples": count,
            "relative_mse": metrics.relative_mse(images[name], reference.image, variance=noise),
            "mse": error - float(noise.mean()),
            "flip": flip(images[name], reference.image),
        }
    return found, images


def plot(found: Found, pictures: Pictures) -> Any:
    """The pictures of codes, and insets of the walk, codes and the reference."""
    picture = figure(9, 8.8)
    panels = picture.subfigures((len(CASES) + 1) // 2, 2).ravel()
    for panel, name in zip(panels, found, strict=False):
        case, shown = CASES[name], pictures(name)
        axes = panel.subplot_mosaic("pabc;pdef", width_ratios=(2.75, 1, 1, 1))
        time = "equal time" if case.samples else "one sample per pixel"
        panel.suptitle(f"{case.title}; {time}", fontsize=8)
        for axis in axes.values():
            axis.set(xticks=[], yticks=[])
        axes["p"].imshow(shown["networks"])
        axes["p"].set_xlabel("codes", fontsize=8)
        for row, ((x, y), colour) in enumerate(zip(case.insets, FRAMES, strict=True)):
            frame = {"edgecolor": colour, "linewidth": 1.2, "facecolor": "none"}
            axes["p"].add_patch(Rectangle((x - 0.5, y - 0.5), SIDE, SIDE, **frame))
            for column, method in enumerate(("walk", "networks", "reference")):
                axis = axes["abcdef"[3 * row + column]]
                axis.imshow(shown[method][y : y + SIDE, x : x + SIDE], interpolation="nearest")
                axis.spines[:].set(color=colour, linewidth=1.2)
                if row == 0:
                    axis.set_title(method, fontsize=8, pad=3)
                elif method in found[name]:
                    of = found[name][method]
                    text = f"{of['samples']} spp\nrel. MSE {of['relative_mse']:.2g}"
                    axis.set_xlabel(f"{text}\nFLIP {of['flip']:.2g}", fontsize=6.5)
    return picture


def tables(found: Found) -> list[str]:
    """The scenes at equal time, at one sample per pixel, and beside the paper's Table 3."""
    equal, single, paper = [], [], []
    for name, methods in found.items():
        case, both = CASES[name], [methods["walk"], methods["networks"]]
        errors = [f"{x['relative_mse']:.2g}" for x in both]
        flips = [f"{x['flip']:.2g}" for x in both]
        if not case.samples:
            single.append([case.title, *errors, *flips])
            continue
        ratio = both[0]["relative_mse"] / both[1]["relative_mse"]
        samples = [f"{x['samples']}" for x in both]
        equal.append([case.title, *samples, *errors, f"{ratio:.1f}", *flips])
        if case.paper and "mse" in both[0]:
            own, (theirs, others) = [x["mse"] for x in both], case.paper.values()
            cells = [f"{1e4 * x:.2g}e-4" for x in own] + [f"{own[0] / own[1]:.2g}"]
            paper.append([case.title, *cells, f"{others[0]}", f"{theirs[1] / others[1]:.2g}"])
    head = ["scene", "samples: walk", "networks", "relative MSE: walk", "networks", "ratio"]
    made = [
        table([*head, "FLIP: walk", "networks"], equal),
        table(["scene", "relative MSE: walk", "networks", "FLIP: walk", "networks"], single),
    ]
    head = ["scene", "MSE: walk", "networks", "walk over networks"]
    return [*made, table([*head, "paper: samples", "ratio"], paper)] if paper else made


EXPERIMENT = Experiment(
    cases=lambda _: CASES, measure=measure, tables=tables, plot=plot, models=NETWORKS, minutes=15
)
