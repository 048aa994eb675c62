"""A sheet of spheres: rows blend from one material to the next, columns are coats.

    python -m benchmarks.sheet MATERIAL MATERIAL... -o sheet.jpg [--rows 5]

A row is `urushi.lerp` of its neighbours among the materials, a column `urushi.layer` over it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from benchmarks import sphere
from benchmarks.showing import figure, mosaic
from benchmarks.subjects import coated
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


def steps(names: Sequence[str], rows: int) -> Iterator[tuple[int, float, str]]:
    """For each row the material before it, its fraction of the way to the next, and its label."""
    for position in np.linspace(0, len(names) - 1, rows):
        k = min(int(position), len(names) - 2)
        shares = {names[k]: 1 - position + k, names[k + 1]: position - k}
        seen = [f"{name} {share:.0%}" for name, share in shares.items() if share > 0]
        yield k, position - k, "\n".join(seen).removesuffix(" 100%")


def main(
    materials: tyro.conf.Positional[tuple[str, ...]],
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])],
    rows: int = 5,
) -> None:
    """Draw a sheet.

    Args:
        materials: two or more, as of `urushi layer`.
        output: the picture.
        rows: two or more.
    """
    if len(materials) < 2 or rows < 2:
        raise SystemExit("a sheet blends materials; give two or more, and two or more rows")
    opened = [read_material(text, None) for text in materials]
    pictures, labels = [], []
    names = [Path(text).stem for text in materials]
    for k, share, label in tqdm(steps(names, rows), total=rows, unit="row"):
        labels.append(label)
        blend = lerp(opened[k], opened[k + 1], share)
        layers = [blend if coat is None else coated(blend, coat) for coat in COATS.values()]
        pictures.append([metrics.shown(sphere.studio(material.f)) for material in layers])
    picture = figure(1.3 * len(COATS) + 1.2, 1.3 * rows + 0.4)
    axis = picture.subplots()
    mosaic(axis, pictures, labels, list(COATS))
    axis.tick_params(top=False, labeltop=True, labelbottom=False)
    axis.spines[:].set_visible(False)
    with atomic_write(output) as temporary:
        picture.savefig(temporary, dpi=100, bbox_inches="tight")
    print(output)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
