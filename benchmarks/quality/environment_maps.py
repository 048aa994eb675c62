"""Environment maps from files, for pictures of spheres by `benchmarks.quality.sphere`."""

import os
from pathlib import Path

import mitsuba as mi
import numpy as np
from benchmarks.quality.sphere import Environment, cell_means, cell_points, periodic_bilinear

from urushi.errors import FileError

#: Maps with more rows or columns than these are reduced first.
LARGEST = (512, 1024)


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
    return Environment(source.stem, cell_means(_look_up(_reduced(image), cell_points())))


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
