"""One look for all figures: sizes, colours of methods, and the file format."""

from pathlib import Path

from matplotlib.figure import Figure

from urushi.files import atomic_write

#: Colours of methods, distinct for colour-blind readers (Okabe and Ito 2008).
COLOURS = {
    "reference": "#000000",
    "networks": "#0072b2",
    "Belcour 2018": "#d55e00",
    "principled": "#009e73",
    "exact": "#cc79a7",
    "Fan et al. 2022": "#e69f00",
}

#: Resolution of pictures in dots per inch.
DPI = 130


def figure(width: float, height: float) -> Figure:
    """An empty figure of a size in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def save(picture: Figure, path: Path) -> None:
    """Write a figure as PNG."""
    with atomic_write(path) as temporary:
        picture.savefig(temporary, format="png", dpi=DPI)
    print(path)
