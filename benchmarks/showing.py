"""How results are shown: tables in Markdown, numbers, intervals, and the look of figures."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

#: Colours of methods, distinct for colour-blind readers (Okabe and Ito 2008); dots per inch.
COLOURS = {
    "walk": "#000000",
    "networks": "#0072b2",
    "Belcour 2018": "#d55e00",
    "principled": "#009e73",
    "exact": "#cc79a7",
    "Fan et al. 2022": "#e69f00",
}
DPI = 130
#: Resamples of a bootstrap interval, and its coverage.
RESAMPLES, COVERAGE = 10_000, 0.95


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    first, *others = ["| " + " | ".join(cells) + " |" for cells in (head, *rows)]
    return "\n".join([first, "|---" * len(head) + "|", *others])


def percent(value: float | None) -> str:
    """A share in per cent, with two significant digits; a dash for nothing."""
    return "–" if value is None else f"{100 * value:.2g} %"


def interval(values: np.ndarray) -> tuple[float, float]:
    """Bootstrap interval of a mean, at `COVERAGE` (Efron 1979, percentile method)."""
    values = np.asarray(values, float)
    rng = np.random.default_rng(0)
    means = values[rng.integers(len(values), size=(RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.percentile(means, 50 * np.array([1 - COVERAGE, 1 + COVERAGE]))
    return float(low), float(high)


def figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def grid(
    size: tuple[float, float],
    titles: Sequence[str],
    rows: Iterable[tuple[str, Sequence[np.ndarray], Sequence[str]]],
) -> Figure:
    """Pictures with titles above the columns; each row has a label, pictures, and notes below."""
    picture, rows = figure(*size), list(rows)
    axes = picture.subplots(len(rows), len(titles), squeeze=False)
    for line, (label, shown, notes) in zip(axes, rows, strict=True):
        line[0].set_ylabel(label, fontsize=8)
        for axis, image, note in zip(line, shown, notes, strict=True):
            axis.imshow(image)
            axis.set(xticks=[], yticks=[])
            axis.set_xlabel(note, fontsize=8)
    for axis, title in zip(axes[0], titles, strict=True):
        axis.set_title(title, fontsize=8)
    return picture


def mosaic(axis: Any, pictures: Any, rows: Sequence[str], columns: Sequence[str]) -> None:
    """Pictures (rows, columns, H, W, 3) in [0, 1] without gaps, and their labels."""
    across, down, height, width, _ = np.shape(pictures)
    whole = np.moveaxis(pictures, 2, 1).reshape(across * height, down * width, 3)
    axis.imshow(whole, interpolation="lanczos")
    axis.set_xticks((np.arange(down) + 0.5) * width, columns)
    axis.set_yticks((np.arange(across) + 0.5) * height, rows, linespacing=1.4)
    axis.tick_params(length=0)
