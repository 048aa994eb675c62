"""Plot of the error E of held-out stacks against each of their parameters."""

import os
from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from urushi.checks import CoatParameters
from urushi.eval.samples import Samples
from urushi.files import atomic_write

#: Number of stacks in a window of the running median.
WINDOW = 15

#: Colours by number of coats.
COLOURS = {0: "#999999", 1: "#1f77b4", 2: "#2ca02c", 5: "#d62728"}


def draw(
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
            colour = COLOURS.get(int(count), "black")
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
