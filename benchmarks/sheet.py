"""A sheet of spheres: rows blend from one material to the next, columns are coats.

    python -m benchmarks.sheet MATERIAL MATERIAL... -o sheet.jpg [--rows 5]

A row is `urushi.lerp` of its neighbours among the materials, a column `urushi.layer` over it.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks import sphere
from benchmarks.measured import coated
from matplotlib.figure import Figure
from tqdm import tqdm

from urushi.app.encode import read_material
from urushi.core import error_metrics as metrics
from urushi.files import atomic_write
from urushi.material import lerp

#: Coats by name: alpha and eta of the interface, and the medium under it; None is no coat.
COATS: dict[str, dict[str, Any] | None] = {
    "bare": None,
    "clear": {"alpha": 0.02, "eta": 1.5},
    "satin": {"alpha": 0.25, "eta": 1.5},
    "amber": {"alpha": 0.05, "eta": 1.5, "sigma_t": (0.1, 0.5, 2.0)},
    "milky": {"alpha": 0.1, "eta": 1.5, "albedo": 0.95, "sigma_t": 0.7},
    "lacquer": {"alpha": 0.05, "eta": 1.5, "albedo": (0.9, 0.15, 0.08), "sigma_t": 1.2},
}


def steps(materials: int, rows: int) -> list[tuple[int, float]]:
    """For each row the index of the material before it, and its fraction of the way to the next."""
    positions = [row * (materials - 1) / (rows - 1) for row in range(rows)]
    lower = [min(int(position), materials - 2) for position in positions]
    return [(k, min(position - k, 1.0)) for k, position in zip(lower, positions, strict=True)]


def labels(names: Sequence[str], rows: int) -> list[str]:
    """The label of each row: its materials and their shares."""
    result = []
    for k, t in steps(len(names), rows):
        parts = [(names[k], 1 - t), (names[k + 1], t)]
        shares = [f"{name} {share:.0%}" for name, share in parts if share > 0]
        whole = [name for name, share in parts if share == 1]
        result.append(whole[0] if whole else "\n".join(shares))
    return result


def draw(
    path: str | os.PathLike,
    pictures: np.ndarray,
    row_labels: Sequence[str],
    column_labels: Sequence[str],
) -> None:
    """Write a sheet of pictures (rows, columns, H, W, 3) of linear radiance, with labels."""
    rows, columns, height, width, _ = pictures.shape
    whole = pictures.transpose(0, 2, 1, 3, 4).reshape(rows * height, columns * width, 3)
    figure = Figure(figsize=(1.3 * columns + 1.2, 1.3 * rows + 0.4), layout="constrained")
    axis = figure.subplots()
    axis.imshow(metrics.shown(whole), interpolation="lanczos")
    axis.set_xticks((np.arange(columns) + 0.5) * width, column_labels)
    axis.set_yticks((np.arange(rows) + 0.5) * height, row_labels, linespacing=1.4)
    axis.tick_params(length=0, top=False, labeltop=True, labelbottom=False)
    axis.spines[:].set_visible(False)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=100, bbox_inches="tight")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("materials", nargs="+", help="two or more, as of `urushi layer`")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--rows", type=int, default=5)
    options = parser.parse_args()
    if len(options.materials) < 2 or options.rows < 2:
        parser.error("a sheet blends materials; give two or more, and two or more rows")
    materials = [read_material(text, None) for text in options.materials]
    pictures = []
    for k, share in tqdm(steps(len(materials), options.rows), unit="row"):
        blend = lerp(materials[k], materials[k + 1], share)
        layers = [blend if coat is None else coated(blend, coat) for coat in COATS.values()]
        pictures.append([sphere.studio(material.f) for material in layers])
    grid = np.array(pictures)
    names = [Path(text).stem for text in options.materials]
    draw(options.output, grid, labels(names, options.rows), list(COATS))
    print(options.output)


if __name__ == "__main__":
    main()
