"""Colour spaces of MaterialX documents, and their conversion to linear sRGB.

Matrices are computed from primaries and white points; the white is adapted by the linear Bradford
transform (Lam 1985; ICC.1:2010, Annex E).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from urushi.errors import FileError

_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
_D65 = (0.3127, 0.3290)
_ACES_WHITE = (0.32168, 0.33767)

#: Primaries (x, y of red, green and blue) and white point.
_REC709 = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), _D65)
_AP1 = ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), _ACES_WHITE)
_AP0 = ((0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), _ACES_WHITE)
_ADOBE = ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06), _D65)
_P3 = ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060), _D65)

Primaries = tuple[tuple[float, float], ...]


def _xyz(xy: tuple[float, float]) -> np.ndarray:
    x, y = xy
    return np.array([x / y, 1.0, (1 - x - y) / y])


def _to_xyz(primaries: Primaries) -> np.ndarray:
    """The matrix from linear RGB to XYZ under the space's own white."""
    columns = np.stack([_xyz(xy) for xy in primaries[:3]], axis=1)
    return columns * np.linalg.solve(columns, _xyz(primaries[3]))


def matrix_to_srgb(primaries: Primaries) -> np.ndarray:
    """The matrix (3, 3) from linear RGB of some primaries to linear sRGB, white to white."""
    source, target = (_BRADFORD @ _xyz(p[3]) for p in (primaries, _REC709))
    adapt = np.linalg.solve(_BRADFORD, (target / source)[:, None] * _BRADFORD)
    return np.linalg.solve(_to_xyz(_REC709), adapt @ _to_xyz(primaries))


def _gamma(exponent: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda encoded: np.maximum(encoded, 0) ** exponent


def _srgb_decode(encoded: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1."""
    high = (np.maximum(encoded, 0.04045) + 0.055) / 1.055
    return np.where(encoded <= 0.04045, encoded / 12.92, high**2.4)


@dataclass(frozen=True)
class ColourSpace:
    """Primaries, and the function from stored values to linear ones; None: they are linear."""

    primaries: Primaries
    decode: Callable[[np.ndarray], np.ndarray] | None = None


#: The spaces by MaterialX's names.
SPACES = {
    "srgb_texture": ColourSpace(_REC709, _srgb_decode),
    "lin_rec709": ColourSpace(_REC709),
    "g18_rec709": ColourSpace(_REC709, _gamma(1.8)),
    "g22_rec709": ColourSpace(_REC709, _gamma(2.2)),
    "rec709_display": ColourSpace(_REC709, _gamma(2.4)),
    "acescg": ColourSpace(_AP1),
    "g22_ap1": ColourSpace(_AP1, _gamma(2.2)),
    "aces2065_1": ColourSpace(_AP0),
    "adobergb": ColourSpace(_ADOBE, _gamma(563 / 256)),
    "lin_adobergb": ColourSpace(_ADOBE),
    "srgb_displayp3": ColourSpace(_P3, _srgb_decode),
    "lin_displayp3": ColourSpace(_P3),
}

#: Other names of the same spaces, among them those of the Color Interop Forum.
ALIASES = {
    "lin_ap1": "acescg",
    "lin_ap1_scene": "acescg",
    "lin_rec709_scene": "lin_rec709",
    "lin_srgb": "lin_rec709",
    "lin_ap0": "aces2065_1",
    "lin_ap0_scene": "aces2065_1",
    "srgb_rec709_scene": "srgb_texture",
    "srgb_rec709_display": "srgb_texture",
    "g22_rec709_scene": "g22_rec709",
    "g18_rec709_scene": "g18_rec709",
    "g22_ap1_scene": "g22_ap1",
    "lin_adobergb_scene": "lin_adobergb",
    "g22_adobergb_scene": "adobergb",
    "lin_p3d65_scene": "lin_displayp3",
    "srgb_p3d65_scene": "srgb_displayp3",
}

#: Names that ask for no conversion.
RAW = ("", "none", "raw", "data")


def to_linear_srgb(colours: npt.ArrayLike, space: str, where: str) -> np.ndarray:
    """Convert colours (..., 3 or 4) of a space to linear sRGB; a fourth channel stays.

    Colours outside sRGB get negative channels.

    Raises:
        FileError: the space is unknown.
    """
    array = np.asarray(colours, np.float64)
    if space in RAW:
        return array
    entry = SPACES.get(ALIASES.get(space, space))
    if entry is None:
        raise FileError(
            f"{where}: the colour space '{space[:60]}' is unknown; use one of {', '.join(SPACES)}"
        )
    colour = array[..., :3] if entry.decode is None else entry.decode(array[..., :3])
    if entry.primaries is not _REC709:
        colour = colour @ matrix_to_srgb(entry.primaries).T
    return np.concatenate([colour, array[..., 3:]], axis=-1)
