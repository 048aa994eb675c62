"""Environment maps for pictures of spheres: two of Urushi's own, and maps from files."""

import os
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np

from urushi.errors import FileError
from urushi.scenes import stage
from urushi.scenes.stage import Light

#: Cells of the grid: elevations from the camera's direction, and azimuths about it.
ELEVATIONS, AZIMUTHS = 96, 192

#: Points per axis of a cell; their mean is the cell's radiance.
FINE = 8

#: Maps with more rows or columns than these are reduced first.
LARGEST = (512, 1024)


@dataclass(frozen=True)
class Environment:
    """Radiance from all directions, on a grid about the axis that the camera looks along.

    Attributes:
        name: for tables.
        radiance: float64 (`ELEVATIONS`, `AZIMUTHS`, 3), the means over cells. Row k lies between
            the angles pi k / ELEVATIONS and pi (k + 1) / ELEVATIONS to +z, where the camera is;
            column m is centred at the azimuth 2 pi m / AZIMUTHS from +x, the picture's right, to
            +y, its top.
    """

    name: str
    radiance: np.ndarray


def cell_points() -> np.ndarray:
    """Unit vectors (ELEVATIONS, FINE, AZIMUTHS, FINE, 3) whose values are averaged over cells."""
    fine = (np.arange(FINE) + 0.5) / FINE
    theta = np.pi * np.add.outer(np.arange(ELEVATIONS), fine) / ELEVATIONS
    phi = 2 * np.pi * np.add.outer(np.arange(AZIMUTHS), fine - 0.5) / AZIMUTHS
    theta, phi = theta[:, :, None, None], phi[None, None]
    shape = ELEVATIONS, FINE, AZIMUTHS, FINE
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    return np.stack([x, y, np.broadcast_to(np.cos(theta), shape)], axis=-1)


def own() -> list[Environment]:
    """Two environments by code: a studio with softboxes, and a low sun in a clear sky."""
    white, warm, blue = (1.0, 1.0, 1.0), (1.0, 0.85, 0.65), (0.55, 0.75, 1.0)
    studio = (
        Light(towards=(-1.0, -0.6, 0.9), size=(0.35, 0.35), radiance=tuple(9 * c for c in white)),
        Light(towards=(1.2, -0.3, 0.3), size=(0.10, 0.55), radiance=tuple(7 * c for c in warm)),
        Light(towards=(0.2, 1.0, 0.6), size=(0.50, 0.12), radiance=tuple(8 * c for c in blue)),
    )
    sun = Light(towards=(0.9, -0.8, 0.75), size=(0.02, 0.02), radiance=(1800.0, 1500.0, 1100.0))
    return [
        _of_stage("studio", (0.35, 0.36, 0.40), (0.25, 0.24, 0.23), (0.08, 0.07, 0.06), studio),
        _of_stage("sun", (0.35, 0.55, 1.0), (1.0, 0.95, 0.85), (0.20, 0.17, 0.13), (sun,)),
    ]


def read(path: str | os.PathLike) -> Environment:
    """Read an equirectangular map as Mitsuba's `envmap` does: row 0 is +y, the middle column +z.

    Raises:
        FileError: the file is missing or no picture.
    """
    source = Path(path)
    if not source.is_file():
        raise FileError(f"there is no file '{source}'; check the path")
    try:
        bitmap = mi.Bitmap(str(source)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False
        )
    except RuntimeError as error:
        raise FileError(
            f"cannot read the environment map '{source}'; give an HDR or EXR picture"
        ) from error
    image = np.asarray(bitmap, dtype=np.float64)
    if not np.isfinite(image).all():
        raise FileError(f"the environment map '{source}' has pixels that are not finite")
    return Environment(source.stem, _cell_means(_look_up(_reduced(image), cell_points())))


def _of_stage(
    name: str,
    zenith: stage.Vector,
    horizon: stage.Vector,
    ground: stage.Vector,
    lights: tuple[Light, ...],
) -> Environment:
    """A sky of `stage.radiance`, in whose frame z is up and the camera at negative y."""
    x, y, z = np.moveaxis(cell_points(), -1, 0)
    points = np.stack([x, -z, y], axis=-1)
    return Environment(name, _cell_means(stage.radiance(points, zenith, horizon, ground, lights)))


def _cell_means(fine: np.ndarray) -> np.ndarray:
    """Means over cells of values at `cell_points`, by solid angle."""
    sine = np.sin(np.pi * (np.arange(ELEVATIONS * FINE) + 0.5) / (ELEVATIONS * FINE))
    weight = sine.reshape(ELEVATIONS, FINE)
    weight = weight / weight.sum(axis=1, keepdims=True)
    return np.einsum("kimjc,ki->kmc", fine, weight) / FINE


def _reduced(image: np.ndarray) -> np.ndarray:
    """The map (H, W, 3) with blocks of pixels averaged until it is at most as large as `LARGEST`.

    Otherwise the points of `cell_points` could miss the pixels of a small sun.
    """
    for axis, most in enumerate(LARGEST):
        count = -(-image.shape[axis] // most)
        kept = image.shape[axis] // count * count
        image = np.moveaxis(image, axis, 0)[:kept]
        image = image.reshape(kept // count, count, *image.shape[1:]).mean(axis=1)
        image = np.moveaxis(image, 0, axis)
    return image


def _look_up(image: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Bilinear values (..., 3) of an equirectangular map towards unit vectors (..., 3)."""
    rows, columns = image.shape[:2]
    x, y, z = np.moveaxis(directions, -1, 0)
    v = np.arccos(np.clip(y, -1, 1)) / np.pi * rows - 0.5
    u = np.arctan2(x, -z) / (2 * np.pi) * columns - 0.5
    return periodic_bilinear(image, np.clip(v, 0, rows - 1), u)


def periodic_bilinear(image: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Bilinear values (..., C) of an image (H, W, C) whose columns are periodic.

    row (...): in [0, H - 1], pixel centres at whole numbers; column (...): any number, of period W,
    pixel centres at whole numbers.
    """
    rows, columns = image.shape[:2]
    above, left = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    down, right = (row - above)[..., None], (column - left)[..., None]
    below = np.minimum(above + 1, rows - 1)
    left, beside = left % columns, (left + 1) % columns
    upper = image[above, left] * (1 - right) + image[above, beside] * right
    lower = image[below, left] * (1 - right) + image[below, beside] * right
    return upper * (1 - down) + lower * down
