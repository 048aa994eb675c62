"""Plots of an evaluation: `python -m benchmarks.quality.eval_plots FOLDER [--weights FILE]`.

Draws errors by parameter (errors.png) and the lobes of the worst stacks (worst.png) of networks on
the stored set, in about a minute.
"""

import argparse
import os
import textwrap
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from benchmarks.evaluation import benchmark, predict, report
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Samples
from matplotlib.figure import Figure

from urushi.checks import CoatParameters
from urushi.files import atomic_write, new_folder
from urushi.nets.weights import Model, find
from urushi.walk import StackTable

#: Number of stacks in a window of the running median.
WINDOW = 15

#: Colours by number of coats.
COAT_COLOURS = {0: "#999999", 1: "#1f77b4", 2: "#2ca02c", 5: "#d62728"}


def draw_errors(
    path: str | os.PathLike, sets: Mapping[str, Samples], errors: Mapping[str, np.ndarray]
) -> None:
    """Scatter E, with its running median, over the top coat's and the bottom's parameters.

    Args:
        path: PNG file to write.
        sets: stacks by group.
        errors: E (S,) of the stacks, by group.

    Raises:
        FileError: the file cannot be written.
    """
    panels = points(sets, errors)
    columns = 5
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(3.2 * columns, 2.6 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, (title, (x, y, coats)) in zip(axes, panels.items(), strict=False):
        for count in np.unique(coats):
            chosen = coats == count
            colour = COAT_COLOURS.get(int(count), "black")
            axis.scatter(x[chosen], y[chosen], s=5, color=colour, label=f"{count} coats")
        axis.plot(*running_median(x, y), color="black", linewidth=1.2)
        axis.set_yscale("log")
        axis.set_title(title, fontsize=9)
    for axis in axes[len(panels) :]:
        axis.set_visible(False)
    for axis in axes[::columns]:
        axis.set_ylabel("E [%]")
    if panels:
        axes[0].legend(fontsize=7)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)


def points(
    sets: Mapping[str, Samples], errors: Mapping[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For each parameter by name: its values, E in percent, and the stacks' numbers of coats."""
    collected: dict[str, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
    for group, e in errors.items():
        table = sets[group].table
        columns = {f"{table.kind}: {name}": x for name, x in table.bottom.items()}
        if table.coats:
            columns |= {
                f"top coat: {name}": getattr(table, name)[:, 0] for name in CoatParameters._fields
            }
        for name, x in columns.items():
            # Exact networks have zero errors, which a logarithmic axis cannot show.
            entry = x, np.maximum(100 * e, 1e-4), np.full(len(e), table.coats)
            collected.setdefault(name, []).append(entry)
    order = sorted(collected, key=lambda name: (not name.startswith("top coat"), name))
    result = {}
    for name in order:
        x, y, coats = (np.concatenate(part) for part in zip(*collected[name], strict=True))
        result[name] = x, y, coats
    return result


def running_median(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Medians of x and y over windows of `WINDOW` neighbours in x; over all if there are fewer."""
    order = np.argsort(x, kind="stable")
    size = min(WINDOW, len(x))
    windows = np.lib.stride_tricks.sliding_window_view
    smooth_x, smooth_y = (np.median(windows(v[order], size), axis=1) for v in (x, y))
    return smooth_x, smooth_y


#: Number of stacks shown, angles of incidence [degrees], and walks per direction.
COUNT, INCIDENT, WALKS = 10, (10.0, 45.0, 75.0), 4096

#: Radii show f cos to this power, so that wide lobes stay visible beside sharp ones.
POWER = 1 / 3

#: Angles of the outgoing directions in the plane, from the normal.
OUTGOING = np.radians(np.linspace(-89.0, 89.0, 179))


def draw_lobes(
    path: str | os.PathLike,
    model: Model,
    sets: Mapping[str, Samples],
    errors: Mapping[str, np.ndarray],
) -> None:
    """Draw reference and networks for the `COUNT` coated stacks of largest E.

    Args:
        path: PNG file to write.
        model: the networks.
        sets: the groups' stacks.
        errors: E (S,) of the groups' stacks.

    Raises:
        FileError: the file cannot be written.
    """
    worst = worst_stacks(sets, errors)
    columns = 5
    rows = max(-(-len(worst) // columns), 1)
    figure = Figure(figsize=(3.6 * columns, 3.2 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, subplot_kw={"projection": "polar"})
    for axis, (group, stack) in zip(axes.ravel(), worst, strict=False):
        reference, network = lobe_values(model, sets[group].table, stack)
        for values, style in ((reference, {"linewidth": 2.5, "alpha": 0.4}), (network, {})):
            for index, lobe in enumerate(values):
                axis.plot(OUTGOING, lobe**POWER, color=f"C{index}", **style)
        axis.set(theta_zero_location="N", thetamin=-90, thetamax=90)
        axis.set_yticklabels([])
        title = (
            f"{group}, E {100 * errors[group][stack]:.1f} %\n{describe(sets[group].table, stack)}"
        )
        axis.set_title(title, fontsize=6)
    for axis in axes.ravel()[len(worst) :]:
        axis.set_visible(False)
    angles = ", ".join(f"{angle:g}°" for angle in INCIDENT)
    figure.suptitle(f"(f cos)^(1/3) for light from {angles}; wide: reference, thin: networks")
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)


def worst_stacks(
    sets: Mapping[str, Samples], errors: Mapping[str, np.ndarray]
) -> list[tuple[str, int]]:
    """Group and index of the coated stacks of largest E, the worst first."""
    listed = [
        (float(e), group, index)
        for group, values in errors.items()
        if sets[group].table.coats
        for index, e in enumerate(values)
    ]
    return [(group, index) for _, group, index in sorted(listed, reverse=True)[:COUNT]]


def lobe_values(model: Model, table: StackTable, stack: int) -> tuple[np.ndarray, np.ndarray]:
    """f cos [1/sr] of reference and networks, (`INCIDENT`, `OUTGOING`) each, noise included."""
    angles = np.radians(INCIDENT)
    count = len(angles), len(OUTGOING)
    # Positive outgoing angles are on the mirror's side.
    wi = np.repeat(_in_plane(-angles), count[1], axis=0)
    wo = np.tile(_in_plane(OUTGOING), (count[0], 1))
    one = _single(table, stack)
    f, se = sampling.walk_all(one, wi[None], wo[None], WALKS, seed=0)
    materials = predict.materials(model, Samples(one, wi[None], wo[None], f, se))
    f_hat = predict.evaluate(materials, wi[None], wo[None])
    cosine = wo[:, 2].reshape(count)
    return f.reshape(count) * cosine, f_hat.reshape(count) * cosine


def describe(table: StackTable, stack: int) -> str:
    """The parameters of one stack in a few lines."""
    lines = [
        " ".join(
            f"{_SYMBOLS[name]}={getattr(table, name)[stack, coat]:.2f}"
            for name in CoatParameters._fields
        )
        for coat in range(table.coats)
    ]
    bottom = " ".join(f"{name}={values[stack]:.2f}" for name, values in table.bottom.items())
    return "\n".join([*lines, *textwrap.wrap(bottom, 60, break_long_words=False)])


_SYMBOLS = {"alpha": "α", "eta": "η", "albedo": "A", "sigma_t": "σ", "g": "g"}


def _single(table: StackTable, stack: int) -> StackTable:
    rows = slice(stack, stack + 1)
    coats = {name: getattr(table, name)[rows] for name in CoatParameters._fields}
    bottom = {name: values[rows] for name, values in table.bottom.items()}
    return StackTable(**coats, kind=table.kind, bottom=bottom)


def _in_plane(angles: np.ndarray) -> np.ndarray:
    """Unit vectors (N, 3) float32 in the xz plane, by signed angles from the normal."""
    return np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=-1).astype(
        np.float32
    )


def main() -> None:
    """Measure the networks and draw both plots."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder to write to")
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    arguments = parser.parse_args()
    model, sets, folder = find(arguments.weights), benchmark.read(), new_folder(arguments.folder)
    errors = report.measure_errors(partial(predict.materials, model), sets).stacks
    draw_errors(folder / "errors.png", sets, errors)
    draw_lobes(folder / "worst.png", model, sets, errors)


if __name__ == "__main__":
    main()
