"""The wavelength as an axis of materials that vary in spectral variants."""

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import within
from urushi.mitsuba.tables import Interpolated
from urushi.textures.axes import LINEAR, Axis, Varying

#: Names of the axis and of the wavelengths on it [nm].
WAVELENGTH, NANOMETRES = "wavelength", "nm"

#: Parts of the spectrum in which a material's changes with the wavelength are found.
WAVELENGTHS = 512

#: Values along the axis at which materials are computed, less one: spectra may be steps.
LEVELS = 64

#: Wavelengths that measured spectra have, many of them no others [nm].
MEASURED = (400.0, 700.0)


def wavelength_ends(roots: Sequence["mi.Object"]) -> tuple[float, float]:
    """The least and the largest wavelength of the axis [nm]; a material is the same beyond them.

    Mitsuba's spectra are zero outside of their ranges. Codes cannot follow that jump, and beyond
    `MEASURED` there is little to see.

    roots: BSDFs and textures of the material.
    """
    parts = [x for root in roots for x in within(root)]
    ranges = [x.wavelength_range() for x in parts if isinstance(x, mi.Texture)]
    low = max(first for first, _ in [spectrum.ENDS, *ranges] if first <= MEASURED[0])
    high = min(last for _, last in [spectrum.ENDS, *ranges] if last >= MEASURED[1])
    return float(low), float(high)


def wavelengths_varying(wavelengths: np.ndarray, changes: np.ndarray) -> Varying:
    """The wavelength as a parameter, on an axis along which the material changes about evenly.

    A half of the axis is even in the wavelength: where nothing changes, the material is known, too.

    changes: (N,) amounts by which it changes between even wavelengths (N + 1,) [nm].
    """
    places = np.append(0, np.cumsum(changes + changes.mean() + 1e-9))
    places /= places[-1]
    table, (first, last) = Interpolated(places[:, None]), wavelengths[[0, -1]].tolist()

    def read(si, active) -> list:
        return [table([(x - first) * (1 / (last - first))])[0] for x in si.wavelengths]

    return Varying(
        Axis(WAVELENGTH, LINEAR, 0.0, 1.0, own=True, levels=LEVELS),
        read,
        places=np.stack([places, wavelengths]),
    )


def along_u(count: int) -> np.ndarray:
    """Points uv (count, 2) in the middles of a row of texels."""
    return np.stack([(np.arange(count) + 0.5) / count, np.full(count, 0.5)], axis=-1)


def wavelengths_of(rows: Mapping[str, np.ndarray], count: int) -> Any:
    """The context in which rows (count,) along u are read at their wavelengths."""
    if not mi.is_spectral:
        return contextlib.nullcontext()
    own = rows.get(NANOMETRES, np.full(count, spectrum.RGB[1]))
    return spectrum.reading_at(own.astype(np.float32))
