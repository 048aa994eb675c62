"""Colours of MaterialX documents in linear sRGB.

Spaces and conversions are those of OpenColorIO's configuration for computer graphics, which comes
with OpenImageIO. It knows the names of MaterialX, of the Color Interop Forum and of ACES.
"""

from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from urushi.errors import FileError

#: The configuration.
CONFIG = "ocio://cg-config-latest"

#: The space of the results, by its name in the configuration.
LINEAR_SRGB = "Linear Rec.709 (sRGB)"

#: Names that ask for no conversion.
RAW = ("", "none", "raw", "data", "utilityraw", "noncolor", "noncolordata", "default", "auto")

#: Further names, of exporters and of older versions: in lower case, only letters and digits.
ALIASES = {
    LINEAR_SRGB: "linear linearsrgb linearrec709 scenelinearrec709srgb linearbt709",
    "sRGB Encoded Rec.709 (sRGB)": "srgb srgb8 srgbrec709display",
    "Gamma 1.8 Encoded Rec.709": "gamma18",
    "Gamma 2.2 Encoded Rec.709": "gamma22",
    "Gamma 2.4 Encoded Rec.709": "gamma24 rec709 rec1886rec709display g24rec709display",
    "Linear Rec.2020": "linearbt2020",
}


def _key(name: str) -> str:
    """A name of a colour space without case, spaces and punctuation."""
    return "".join(x for x in name.lower() if x.isalnum())


@cache
def spaces() -> dict[str, str]:
    """The spaces of the configuration by keys of all their names."""
    import OpenImageIO as oiio

    config = oiio.ColorConfig(CONFIG)
    found = {_key(x): name for name, keys in ALIASES.items() for x in keys.split()}
    for name in config.getColorSpaceNames():
        found |= {_key(x.removeprefix("ocio:")): name for x in (name, *config.getAliases(name))}
    return found


def to_linear_srgb(colours: npt.ArrayLike, space: str, where: str) -> np.ndarray:
    """Convert colours (..., 3 or 4) of a space to linear sRGB; a fourth channel stays.

    Colours outside sRGB get negative channels.
    """
    array, key = np.asarray(colours), _key(space)
    name = LINEAR_SRGB if key in RAW else spaces().get(key)
    if name == LINEAR_SRGB:
        return array
    if name is None:
        raise FileError(
            f"{where}: the colour space '{space[:60]}' is unknown; use one of OpenColorIO's "
            "configuration for computer graphics, such as srgb_texture, lin_rec709 or acescg"
        )
    if array.ndim == 1:
        converted = _constant(name, *array[:3].tolist())
    else:
        converted = _converted(name, array[..., :3]).reshape(*array.shape[:-1], 3)
    return np.concatenate([converted, array[..., 3:]], axis=-1)


def _converted(name: str, colours: np.ndarray) -> np.ndarray:
    """Colours (..., 3) of a space of the configuration in linear sRGB, (N, 3)."""
    import OpenImageIO as oiio

    pixels = np.ascontiguousarray(colours, np.float32).reshape(1, -1, 3)
    converted = oiio.ImageBufAlgo.colorconvert(
        oiio.ImageBuf(pixels), name, LINEAR_SRGB, colorconfig=CONFIG
    ).get_pixels(oiio.FLOAT)
    assert converted is not None  # the space is known
    return converted.reshape(-1, 3)


@lru_cache(maxsize=1024)
def _constant(name: str, *rgb: float) -> np.ndarray:
    """`_converted` of one colour (3,): OpenImageIO reads its configuration at every call."""
    return _converted(name, np.array(rgb))[0]
