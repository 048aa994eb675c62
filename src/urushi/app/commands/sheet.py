"""`urushi sheet`: pictures of blended and coated materials."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import tyro
from tqdm import tqdm

from urushi import platform
from urushi.app.describe import describe, is_description
from urushi.errors import ParameterError

if TYPE_CHECKING:
    from urushi.material import Material


@dataclass(frozen=True)
class Sheet:
    """Draw a sheet of spheres: rows go from one material to the next, columns are coats.

    Rows are linear blends of latent codes, and coats are laid over them by the layering network. A
    material is a file of `urushi encode`, a measured BRDF (MERL or RGL) or a description.

    Example: urushi sheet gold.safetensors "diffuse(0.4)" --rows 5 -o sheet.png
    """

    materials: tyro.conf.Positional[tuple[str, ...]]
    """Two or more: the first row, the last, and in their order those in between."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Picture to write (.png, .jpg or .pdf)."""
    rows: int = 5
    """Number of rows, two or more."""
    coats: tuple[str, ...] = ("bare", "clear", "satin", "amber", "milky", "lacquer")
    """Names of the columns' coats, out of those of the default."""
    weights: str | None = None
    """Networks: base (the default), small, or a weights file."""

    def run(self) -> int:
        platform.require_extra("eval")
        from urushi.eval import sheet

        sheet.check_path(self.output)
        coats = sheet.chosen(self.coats)
        if len(self.materials) < 2:
            raise ParameterError("a sheet goes from one material to another; give two or more")
        materials = [self._material(text) for text in self.materials]
        pictures: dict[tuple[int, int], np.ndarray] = {}
        total = self.rows * len(coats)
        with tqdm(total=total, unit="sphere", disable=None) as progress:
            for cell in sheet.cells(materials, self.rows, coats):
                pictures[cell.row, cell.column] = sheet.picture(cell.material)
                progress.update()
        grid = np.stack([[pictures[i, k] for k in range(len(coats))] for i in range(self.rows)])
        names = [text if is_description(text) else Path(text).stem for text in self.materials]
        sheet.draw(self.output, grid, sheet.labels(names, self.rows), list(coats))
        print(self.output)
        return 0

    def _material(self, text: str) -> "Material":
        import urushi

        if is_description(text):
            return urushi.encode(describe(text), self.weights)
        if Path(text).suffix == ".safetensors":
            return urushi.load(text, self.weights)
        return urushi.encode(urushi.load_measured(text), self.weights, refine=True)
