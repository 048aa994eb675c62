"""The values that textures have on a surface: their ranges, which are checked."""

from collections.abc import Callable, Sequence

import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core.appearance import LOOK, PHYSICAL
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import not_over_uv, varying_textures
from urushi.mitsuba.reading.parameters import CHECKS, CoatTextures

#: Textures of indices of refraction.
INDICES = ("int_ior", "ext_ior")

#: Points of uv of what is no bitmap, along each side, and those for more than one texture.
SIDE, POINTS = 256, 1 << 14


def check_coat(coat: CoatTextures) -> None:
    """Check all values of a coat's textures; the walk clips those on meshes and in space."""
    given = {name: [texture] for name, texture in coat.textures.items() if name not in INDICES}
    given["eta"] = [coat.textures[name] for name in INDICES if name in coat.textures]
    for name, textures in given.items():
        label = "int_ior / ext_ior" if name == "eta" else name
        if follows := [x for texture in textures for x in getattr(texture, "sources", ())]:
            label += f", which follows from {', '.join(follows)},"
        varying = varying_textures(*textures) or [x for x in textures if x.is_spatially_varying()]
        if varying:
            label = f"a texel of {label}"

        def read(si, active, name=name, textures=textures) -> list:
            if name in coat.names and name not in PHYSICAL:  # those are without the thickness
                return coat.at(si, active)[name]
            if name in (*LOOK, *PHYSICAL):
                return [*textures[0].eval(si, active)]
            return [textures[0].eval_1(si, active)]

        ends = np.array(range_of(read, textures, (np.nan, np.nan), name != "eta"))
        if np.isnan(ends).all() and not_over_uv(*textures):
            continue
        ends = ends.astype(np.float64).round(6)
        if varying and CHECKS[name] is CHECKS["alpha"]:  # dark texels of a map, as in the walk
            ends = np.where((ends >= 0) & (ends < MIN_ALPHA), MIN_ALPHA, ends)
        CHECKS[name](ends, f"{coat.where}: {label}", any_shape=True)


def range_of(
    read: Callable[..., list],
    textures: Sequence["mi.Texture"],
    whole: tuple[float, float],
    plain: bool,
) -> tuple[float, float]:
    """The least and the largest value that a parameter has on a surface.

    It is known at the texels of a bitmap. What is given on a mesh or in space has all values.

    Args:
        read: from surface interactions and active lanes to the values.
        textures: on which it depends.
        whole: all values.
        plain: whether it is the value of the only texture.
    """
    varying = varying_textures(*textures)
    if not varying:
        values = spectrum.channels_at(spectrum.MIDDLE, read)
        return float(values.min()), float(values.max())
    if not_over_uv(*textures):
        return whole
    only = varying[0]
    bitmap = only.class_name().startswith("BitmapTexture")
    chosen: Sequence[int] = ()
    if bitmap and plain and only is textures[0] and not mi.is_spectral:
        # Values rise with the stored numbers, which may be whole and have the gamma of colours.
        texels = mi.traverse(only)["data"].numpy()
        texels = texels.reshape(-1, texels.shape[-1])
        if texels.shape[1] == 1 or len(read(spectrum.points(spectrum.MIDDLE), True)) > 1:
            chosen = [*texels.argmin(axis=0).tolist(), *texels.argmax(axis=0).tolist()]
    places = [texel_centres(x, chosen) for x in varying]
    if len(places) > 1:  # a function of several textures may be extreme between their texels
        places.append(np.random.default_rng(0).random((POINTS, 2)))
    with spectrum.reading_at(spectrum.FINE):
        values = spectrum.channels_at(np.concatenate(places), read)
    return float(values.min()), float(values.max())


def texel_centres(texture: "mi.Texture", chosen: Sequence[int] = ()) -> np.ndarray:
    """The uv (M, 2) of the centres of a texture's texels, or of a grid; chosen: of some."""
    parameters, (width, height) = mi.traverse(texture), texture.resolution()
    if width * height <= 1:
        width = height = SIDE
    index = np.array(chosen) if len(chosen) else np.arange(width * height)
    x = np.stack([index % width + 0.5, index // width + 0.5], axis=-1) / (width, height)
    if "to_uv" not in parameters:
        return x
    matrix = np.asarray(parameters["to_uv"].matrix.numpy(), np.float64).reshape(3, 3)
    return np.linalg.solve(matrix[:2, :2], (x - matrix[:2, 2]).T).T
