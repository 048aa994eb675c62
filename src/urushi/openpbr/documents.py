"""Materials of MaterialX documents as descriptions of the Mitsuba plugin `openpbr`."""

import os
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.errors import FileError, ParameterError
from urushi.openpbr.inputs import EMISSION, Inputs
from urushi.openpbr.materialx.baking import Texture
from urushi.openpbr.materialx.surface import RESOLUTION, ParameterValue, Surface, read_surface
from urushi.openpbr.parameters import PARAMETERS

_FORMATS = ("Y", "YA", "RGB", "RGBA")


def load_materialx(
    path: str | os.PathLike,
    name: str | None = None,
    resolution: int = RESOLUTION,
    uv_plane: bool = False,
) -> dict[str, Any]:
    """Read a material of a MaterialX document.

    `open_pbr_surface` is read directly; `standard_surface`, `gltf_pbr`, `UsdPreviewSurface`,
    `disney_principled` and `surface_unlit` are translated. Colours become linear sRGB. A parameter
    that depends on one image has that image's texels; patterns and combinations of images are
    computed on a grid over [0, 1]^2 of uv.

    Args:
        path: the document (.mtlx), of MaterialX 1.39 or older.
        name: of the material; None: the document's only one.
        resolution: rows and columns of the grid, in [1, 4096].
        uv_plane: whether patterns in space are taken on the plane (u, v, 0); else they are refused.

    Returns:
        A description for `mi.load_dict` of the plugin `openpbr`. Numbers are floats, colours
        dictionaries of type `rgb`, textures of type `bitmap`. Parameters that the document leaves
        out are missing.

    Raises:
        FileError: the document, or a file that it includes or an image, is missing, damaged, too
            large or has something that is not supported.
        ParameterError: there is no such material, it is one of several and no name is given, or a
            parameter is out of its range.
        PlatformError: the package materialx is needed and missing.
    """
    surface = read_surface(path, decode, name, checked_resolution(resolution), uv_plane)
    values = {name: mitsuba_value(name, value) for name, value in surface.values.items()}
    return {"type": "openpbr", **values}


def check_supported(surface: Surface) -> None:
    """Refuse a material that the plugin `openpbr` cannot render; an emitter takes its emission.

    Raises:
        ParameterError: it asks for a feature that is not supported.
    """
    props = mi.Properties("openpbr")
    props.set_id(surface.name)
    for name, value in surface.values.items():
        if name in EMISSION:
            continue
        if isinstance(value, Texture):
            props[name] = mi.load_dict(mitsuba_value(name, value))
        else:
            props[name] = mi.ScalarColor3f(value) if isinstance(value, tuple) else value
    Inputs(props)


def checked_resolution(resolution: int) -> int:
    """The resolution, in [1, 4096].

    Raises:
        ParameterError: it is not.
    """
    if not 1 <= resolution <= 4096:
        raise ParameterError(f"resolution is {resolution}; it must be in [1, 4096]")
    return int(resolution)


def decode(path: Path) -> np.ndarray:
    """The stored values of an image, float32 (height, width, channels), not linearised.

    Raises:
        FileError: it is damaged, or has other channels than grey or RGB with or without alpha.
    """
    try:
        bitmap = mi.Bitmap(str(path))
        layout = str(bitmap.pixel_format()).rpartition(".")[2]
        if layout not in _FORMATS:
            raise FileError(f"'{path}' has the channels {layout}; convert it to grey or RGB")
        bitmap.set_srgb_gamma(False)  # keeps what is stored
        pixels = np.array(bitmap.convert(component_format=mi.Struct.Type.Float32))
    except RuntimeError as error:
        reason = " ".join(str(error).split())[:160]
        raise FileError(f"cannot read the image '{path}': {reason}") from error
    return pixels.reshape(*pixels.shape[:2], -1)


def mitsuba_value(name: str, value: ParameterValue) -> Any:
    """A parameter's value as `mi.load_dict` takes it.

    Raises:
        ParameterError: it is a texture and no variant is set.
    """
    if isinstance(value, tuple):
        return {"type": "rgb", "value": list(value)}
    if not isinstance(value, Texture):
        return value
    if mi.variant() is None:
        raise ParameterError(
            f"{name} is a texture, which needs a Mitsuba variant; set one first, for instance by "
            "mi.set_variant('llvm_ad_rgb')"
        )
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(value.pixels)),
        "raw": is_raw(name),
        "to_uv": mi.ScalarTransform3f(value.to_uv.tolist()),
        "wrap_mode": value.wrap,
        "filter_type": filter_type(value),
    }


def is_raw(name: str) -> bool:
    """Whether a parameter's texture holds numbers, not colours."""
    return PARAMETERS[name].kind != "color"


def filter_type(texture: Texture) -> str:
    """Mitsuba's name for how a texture is interpolated."""
    return "bilinear" if texture.blend else "nearest"
