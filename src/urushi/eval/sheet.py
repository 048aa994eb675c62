"""Pictures of materials: sheets of blends under coats, and a sphere for a notebook.

A sheet has blends of materials from row to row, and coats from column to column. Both are
arithmetic on latent codes: a row is `urushi.lerp` of its neighbours among the materials, a column
`urushi.layer` over it.
"""

import functools
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.eval import metrics, sphere
from urushi.files import atomic_write
from urushi.material import Material, layer, lerp
from urushi.walk import dielectric

#: Coats by name: alpha and eta of the interface, and the medium under it; None is no coat.
COATS: dict[str, dict[str, Any] | None] = {
    "bare": None,
    "clear": {"alpha": 0.02, "eta": 1.5},
    "satin": {"alpha": 0.25, "eta": 1.5},
    "amber": {"alpha": 0.05, "eta": 1.5, "sigma_t": (0.1, 0.5, 2.0)},
    "milky": {"alpha": 0.1, "eta": 1.5, "albedo": 0.95, "sigma_t": 0.7},
    "lacquer": {"alpha": 0.05, "eta": 1.5, "albedo": (0.9, 0.15, 0.08), "sigma_t": 1.2},
}

#: Suffixes of the picture files that a sheet can be written to.
SUFFIXES = (".png", ".jpg", ".pdf")


class Cell(NamedTuple):
    """One sphere of a sheet with its row and column."""

    row: int
    column: int
    material: Material


def cells(
    materials: Sequence[Material], rows: int, coats: Mapping[str, Mapping[str, Any] | None]
) -> Iterator[Cell]:
    """The materials of a sheet, row by row.

    Args:
        materials: two or more, of the same networks; rows go from the first over the others to the
            last at equal steps.
        rows: two or more.
        coats: by name, as in `COATS`.

    Raises:
        ParameterError: too few materials or rows, no coats, different networks, materials that
            have neither one nor three channels, or a coat's parameter is out of range.
    """
    _check(materials, rows, coats)
    for row, (k, t) in enumerate(steps(len(materials), rows)):
        blend = lerp(materials[k], materials[k + 1], t)
        for column, coat in enumerate(coats.values()):
            yield Cell(row, column, blend if coat is None else coated(blend, **coat))


def steps(materials: int, rows: int) -> list[tuple[int, float]]:
    """For each row the index of the material before it, and its fraction of the way to the next."""
    positions = [row * (materials - 1) / (rows - 1) for row in range(rows)]
    lower = [min(int(position), materials - 2) for position in positions]
    return [(k, min(position - k, 1.0)) for k, position in zip(lower, positions, strict=True)]


def coated(material: Material, *, alpha: float, eta: float, **medium: Any) -> Material:
    """A material under a coat of `COATS`."""
    return layer(dielectric(alpha, eta), material, **medium)


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
    """Write a sheet.

    Args:
        path: .png, .jpg or .pdf.
        pictures: (rows, columns, H, W, 3) of linear radiance.
        row_labels, column_labels: text beside the rows and above the columns.

    Raises:
        FileError: the file cannot be written.
    """
    from matplotlib.figure import Figure  # lazily: an extra

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


def check_path(path: Path) -> None:
    """Raise ParameterError unless a sheet can be written to such a file."""
    if path.suffix.lower() not in SUFFIXES:
        raise ParameterError(
            f"'{path}' does not end in a picture format; use one of {', '.join(SUFFIXES)}"
        )


def chosen(names: Sequence[str]) -> dict[str, dict[str, Any] | None]:
    """The coats of these names.

    Raises:
        ParameterError: there is no such coat, or one is named twice.
    """
    for name in names:
        if name not in COATS:
            raise ParameterError(f"there is no coat '{name}'; choose from {', '.join(COATS)}")
    if len(set(names)) < len(names):
        raise ParameterError(f"a coat is named twice: {', '.join(names)}; leave one out")
    return {name: COATS[name] for name in names}


def _check(materials: Sequence[Material], rows: int, coats: Mapping[str, Any]) -> None:
    if len(materials) < 2:
        raise ParameterError(f"a sheet of {len(materials)} materials has no rows; give two or more")
    if rows < 2:
        raise ParameterError(f"a sheet has {rows} rows; give two or more")
    if not coats:
        raise ParameterError("a sheet without coats has no columns; give one or more, or 'bare'")
    for material in materials:
        if material.channels not in (1, 3):
            raise ParameterError(
                f"a material has {material.channels} channels; only those of one or three can be "
                "shown"
            )
    fingerprints = {material.model.fingerprint for material in materials}
    if len(fingerprints) > 1:
        raise ParameterError(
            "the materials were encoded with different weights, "
            f"{', '.join(sorted(fingerprints))}; encode all with the same weights"
        )


#: Number of pictures that are remembered: a notebook shows the same material several times.
REMEMBERED = 32


@functools.lru_cache(REMEMBERED)
def png(material: Material) -> bytes:
    """A sphere in Urushi's studio as a PNG file, 128 pixels across, transparent around it.

    material: of one or three channels. The tangents of an anisotropic one point away from the
    middle. A picture takes about two seconds.
    """
    import mitsuba as mi  # lazily: a notebook may never show a material

    alpha = sphere.mask().astype(float)[..., None]
    pixels = np.concatenate([metrics.shown(sphere.studio(material.f)), alpha], axis=-1)
    stream = mi.MemoryStream()
    bitmap = mi.Bitmap((255 * pixels + 0.5).astype(np.uint8), mi.Bitmap.PixelFormat.RGBA)
    bitmap.write(stream, mi.Bitmap.FileFormat.PNG)
    return bytes(stream.raw_buffer())
