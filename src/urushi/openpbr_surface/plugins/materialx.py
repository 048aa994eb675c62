"""The plugin `materialx`, and materials of MaterialX documents as descriptions of `openpbr`."""

import os
from collections.abc import Callable, Mapping
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.mitsuba.properties import check_names, describe, path_of, switch_of
from urushi.openpbr_surface.inputs import OPTIONS, Inputs
from urushi.openpbr_surface.materialx import surface
from urushi.openpbr_surface.materialx.baking import Texture
from urushi.openpbr_surface.parameters import EMISSION, PARAMETERS


def load_materialx(
    path: str | os.PathLike,
    name: str | None = None,
    resolution: int = surface.RESOLUTION,
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
        A description for `mi.load_dict` of the plugin `openpbr`, or of `blendbsdf` for a mixture of
        shaders. Numbers are floats, colours dictionaries of type `rgb`, textures of type `bitmap`.
        Parameters that the document leaves out are missing. A BSDF has no medium and emits nothing:
        `urushi.openpbr(**description).on(shape)` gives both to a shape.

    Raises:
        FileError: the document, or a file that it includes or an image, is missing, damaged, too
            large or has something that is not supported.
        ParameterError: there is no such material, it is one of several and no name is given, or a
            parameter is out of its range.
        PlatformError: the package materialx is needed and missing.
    """
    return description(surface.read_surface(path, name, resolution, uv_plane))


def description(
    found: surface.Surface | surface.Mix,
    extra: Mapping[str, Any] = {},
    where: str = "",
    stored: Callable[[str, np.ndarray], dict[str, Any]] | None = None,
) -> dict[str, Any]:
    """A dictionary for `mi.load_dict`.

    extra: further properties of each `openpbr`. where: begins its errors, before the document.
    stored: as of `mitsuba_value`.
    """
    if isinstance(found, surface.Mix):
        parts = {"bsdf_0": found.bg, "bsdf_1": found.fg}
        made = {name: description(part, extra, where, stored) for name, part in parts.items()}
        return {"type": "blendbsdf", "weight": mitsuba_value("mix", found.weight, stored), **made}
    values = {name: mitsuba_value(name, value, stored) for name, value in found.values.items()}
    origin = {"origin": f"{where}: {found.where}"} if where else {}
    return {"type": "openpbr", **values, **extra, **origin}


def check_supported(found: surface.Surface | surface.Mix, *, alone: bool = True) -> None:
    """Refuse a material that the plugin `openpbr` cannot render.

    alone: whether its shape has its emission and its medium; mixtures have neither.
    """
    if isinstance(found, surface.Mix):
        check_supported(found.bg, alone=False)
        check_supported(found.fg, alone=False)
        return
    values = {
        name: mitsuba_value(name, value) if isinstance(value, Texture) else value
        for name, value in found.values.items()
        if not (alone and name in EMISSION)
    }
    Inputs.of(values | {"interior": alone}, found.where)


def mitsuba_value(
    name: str,
    value: surface.ParameterValue,
    stored: Callable[[str, np.ndarray], dict[str, Any]] | None = None,
) -> Any:
    """A parameter's value as `mi.load_dict` takes it.

    stored: from the parameter's name and the pixels of its texture to the property of `bitmap` that
        has them; by default they are in memory.
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
    pixels = np.ascontiguousarray(value.pixels)
    return {
        "type": "bitmap",
        **({"bitmap": mi.Bitmap(pixels)} if stored is None else stored(name, pixels)),
        "raw": name not in PARAMETERS or PARAMETERS[name].kind != "color",
        "to_uv": mi.ScalarTransform3f(value.to_uv.tolist()),
        "wrap_mode": value.wrap,
        "filter_type": "bilinear" if value.blend else "nearest",
    }


def materialx(props):
    """A material of a MaterialX document (``materialx``).

    ============== ===================== ====================================================
    filename       string                The document (``.mtlx``), relative to the scene file.
                                         (Required)
    material       string                Name of the material. (Default: the document's only
                                         one)
    bake           integer               Rows and columns of textures that are computed from
                                         patterns. (Default: 1024)
    uv_plane       boolean               Take patterns in space on the plane (u, v, 0) instead
                                         of refusing them. (Default: false)
    ============== ===================== ====================================================

    The plugin makes an instance of ``openpbr``, which gets all other properties: ``reference``,
    ``unsupported``, ``interior``, and parameters of OpenPBR, which replace those of the
    document. A mixture of two shaders is a ``blendbsdf`` of two instances. ``urushi convert``
    writes a shape with the medium and the emitter that a document asks for.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="materialx">
                <string name="filename" value="paints.mtlx"/>
                <string name="material" value="Red"/>
            </bsdf>

        .. code-tab:: python

            'type': 'materialx',
            'filename': 'paints.mtlx',
            'material': 'Red'
    """
    where, own = describe(props), ("filename", "material", "bake", "uv_plane")
    check_names(props, (*own, *OPTIONS, *PARAMETERS), where)
    if "filename" not in props:
        raise ParameterError(f"{where} has no filename; give a MaterialX document")
    path, name = path_of(props, "filename"), props.get("material", None)
    resolution = surface.RESOLUTIONS(props.get("bake", surface.RESOLUTION), f"{where}: bake")
    plane = switch_of(props, "uv_plane")
    extra = {key: props[key] for key in list(props.keys()) if key not in own}
    bsdf = description(surface.read_surface(path, name, int(resolution), plane), extra, where)
    if props.id():
        bsdf["id"] = props.id()
    return mi.load_dict(bsdf)
