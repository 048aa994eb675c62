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

#: Other names of the same spaces, of the Color Interop Forum, OpenColorIO's configurations and
#: exporters; in lower case, without anything but letters and digits.
ALIASES = {
    "srgb_texture": "srgb srgbtexture srgbrec709scene srgbrec709display utilitysrgbtexture "
    "srgbencodedrec709srgb srgb8 inputgenericsrgbtexture",
    "lin_rec709": "linear linrec709scene linsrgb linearsrgb linearrec709srgb linearrec709 "
    "utilitylinearsrgb utilitylinearrec709 scenelinearrec709srgb linearbt709",
    "g18_rec709": "gamma18 g18rec709scene gamma18rec709texture gamma18encodedrec709",
    "g22_rec709": "gamma22 g22rec709scene gamma22rec709texture gamma22encodedrec709",
    "rec709_display": "gamma24 rec709 rec1886rec709display",
    "acescg": "linap1 linap1scene acesacescg",
    "g22_ap1": "g22ap1scene gamma22encodedap1",
    "aces2065_1": "linap0 linap0scene acesaces20651",
    "adobergb": "g22adobergbscene gamma22encodedadobergb",
    "lin_adobergb": "linadobergbscene linearadobergb",
    "srgb_displayp3": "srgbp3d65scene srgbencodedp3d65",
    "lin_displayp3": "linp3d65scene linearp3d65",
}

#: Names that ask for no conversion.
RAW = ("", "none", "raw", "data", "utilityraw", "noncolor", "noncolordata", "default", "auto")


def _key(name: str) -> str:
    """A name of a colour space without case, spaces and punctuation."""
    return "".join(x for x in name.lower() if x.isalnum())


_BY_KEY = {_key(name): space for name, space in SPACES.items()} | {
    key: SPACES[name] for name, keys in ALIASES.items() for key in keys.split()
}


def to_linear_srgb(colours: npt.ArrayLike, space: str, where: str) -> np.ndarray:
    """Convert colours (..., 3 or 4) of a space to linear sRGB; a fourth channel stays.

    Colours outside sRGB get negative channels.
    """
    array = np.asarray(colours, np.float64)
    if (key := _key(space)) in RAW:
        return array
    entry = _BY_KEY.get(key)
    if entry is None:
        raise FileError(
            f"{where}: the colour space '{space[:60]}' is unknown; use one of {', '.join(SPACES)}"
        )
    colour = array[..., :3] if entry.decode is None else entry.decode(array[..., :3])
    if entry.primaries is not _REC709:
        colour = colour @ matrix_to_srgb(entry.primaries).T
    return np.concatenate([colour, array[..., 3:]], axis=-1)
