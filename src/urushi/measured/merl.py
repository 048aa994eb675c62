"""MERL tables: isotropic BRDFs measured by Matusik et al., "A data-driven reflectance model", 2003.

A `.binary` file is little-endian: three int32 (90, 90, 180), then the planes R, G and B of float64,
each indexed by (theta_h, theta_d, phi_d). The planes are in units of 1/1500, 1.15/1500 and
1.66/1500 per steradian.

The database's own reader (BRDFRead.cpp) finds a bin by truncation,
    i = floor(90 sqrt(theta_h / 90 deg)),  j = floor(theta_d / 1 deg),  k = floor(phi_d / 1 deg).
Bin i therefore spans [i, i + 1) on its axis, and its value belongs to the centre, i + 0.5.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from urushi.core.directions import above_horizon
from urushi.errors import FileError
from urushi.measured import tabulated

#: Bins along theta_h, theta_d and phi_d.
SHAPE = (90, 90, 180)

#: Factors of the planes R, G and B that give values in 1/sr.
SCALE = (1 / 1500, 1.15 / 1500, 1.66 / 1500)

#: The first bytes of every MERL file.
HEADER = np.array(SHAPE, "<i4").tobytes()

#: Size of every MERL file in bytes.
FILE_SIZE = len(HEADER) + 3 * 8 * SHAPE[0] * SHAPE[1] * SHAPE[2]


class Merl(tabulated.MeasuredSurface):
    """A BRDF given by a table over half and difference angles; reciprocal and isotropic.

    Evaluation is trilinear between bin centres, along sqrt(theta_h), theta_d and phi_d:
    - phi_d is periodic over 180 degrees, as reciprocity requires; f(wi, wo) = f(wo, wi) exactly.
    - Below the first centre of theta_h and theta_d the first bin's value is used. Reciprocity makes
      f even about both zeros, so that this loses nothing.
    - Above the last centre, at grazing angles, the last bin's value is used.
    - A bin is invalid if any channel is negative or if its centre has a direction below the
      horizon. Negative values mark bins that could not be measured, many of them beyond about 80
      degrees. Invalid bins are filled by `tabulated.fill_nearest`, so that no mark enters the
      interpolation.
    """

    def __init__(self, table: npt.ArrayLike) -> None:
        """Take a table [1/sr] of shape (90, 90, 180, 3), indexed (theta_h, theta_d, phi_d, RGB).

        Raises:
            FileError: an entry is not finite, or none is valid.
        """
        with np.errstate(over="ignore"):
            values = np.array(table, np.float32)
        if values.shape != (*SHAPE, 3):
            raise FileError(
                f"a MERL table has shape {(*SHAPE, 3)}, not {values.shape}; "
                "index it by theta_h, theta_d, phi_d and channel"
            )
        if not np.isfinite(values).all():
            count = int((~np.isfinite(values)).any(-1).sum())
            raise FileError(
                f"the MERL table has {count} bins that are not finite; obtain the file again"
            )
        valid = (values >= 0).all(-1) & above_horizon(*tabulated.bin_centres(SHAPE))
        if not valid.any():
            raise FileError(
                "the MERL table has no valid bin: above the horizon, each has a negative channel; "
                "obtain it again"
            )
        tabulated.fill_nearest(values, valid)
        self._table = values

    def _lookup(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return tabulated.interpolated(self._table, wi, wo)

    def table(self) -> np.ndarray:
        """The filled table, float32 (90, 90, 180, 3) [1/sr]."""
        return self._table


def read(path: Path) -> np.ndarray:
    """The table of a file that begins with `HEADER`."""
    size = path.stat().st_size
    if size != FILE_SIZE:
        kind = "truncated" if size < FILE_SIZE else "too long"
        raise FileError(
            f"the MERL file '{path}' is {kind} ({size} bytes, not {FILE_SIZE}); obtain it again"
        )
    table = np.empty((*SHAPE, 3), np.float32)
    with path.open("rb") as file:
        file.seek(len(HEADER))
        for channel, scale in enumerate(SCALE):
            plane = np.fromfile(file, "<f8", SHAPE[0] * SHAPE[1] * SHAPE[2])
            with np.errstate(all="ignore"):  # values out of range become infinite: see Merl
                table[..., channel] = (plane * scale).reshape(SHAPE)
    return table
