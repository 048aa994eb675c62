"""The grid of texels on which textures of a coat are projected, chosen from the textures.

Textures that share one `to_uv` transform are projected in their own space. A pattern that the
transform repeats is then projected once and has no seam.
"""

from collections.abc import Mapping

import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import not_over_uv, varying_textures
from urushi.textures.store import IDENTITY, TexelGrid, from_texture

#: Texels per side for procedural textures, and the largest side that is chosen automatically.
PROCEDURAL, LARGEST = 256, 2048

#: Points at which a bitmap is evaluated to detect how it wraps and filters.
POINTS = 64


def choose(
    parts: Mapping[str, "mi.Object"], nested: TexelGrid | None, resolution: int, where: str
) -> TexelGrid | None:
    """The grid that resolves all textures and the bottom's latent texture; None if all is constant.

    Args:
        parts: the objects that hold the textures, by the names that errors use.
        nested: the grid of the bottom's codes, if it has one.
        resolution: texels per side; 0 to choose it from the textures.
        where: start of errors and warnings.
    """
    grids = [nested] if nested else []
    for name, part in parts.items():
        if dependence := not_over_uv(part):
            raise ParameterError(
                f"{where}: {name} depends on {dependence}, but coats are baked over uv; "
                "give a texture over uv, or use the plugin 'layered', which evaluates every point"
            )
        grids += map(_texture_grid, varying_textures(part))
    if not grids:
        return None
    spaces = {np.array(grid.to_texture).round(6).tobytes() for grid in grids}
    wraps = {grid.wrap for grid in grids}
    wrap = wraps.pop() if len(wraps) == 1 else "repeat"
    if len(spaces) == 1:
        place, sizes = grids[0].to_texture, [(grid.width, grid.height) for grid in grids]
    else:
        place, wrap, sizes, seamless = IDENTITY, "repeat", [], True
        for grid in grids:
            linear = np.array(grid.to_texture)[:, :2]
            scale = np.abs(linear).max(axis=1)  # repetitions over the unit square of uv
            sides = zip((grid.width, grid.height), scale, strict=True)
            sizes.append(tuple(max(round(side * x), 1) for side, x in sides))
            whole = np.abs(linear - linear.round()).max() < 1e-4
            seamless &= grid.wrap == "repeat" and bool(whole)
        if not seamless:
            mi.Log(
                mi.LogLevel.Warn,
                f"{where}: its textures have different to_uv transforms, one of which does not map "
                "the unit square of uv onto whole repetitions: a seam is left where uv repeats; "
                "give all textures the same to_uv",
            )
    width, height = (min(max(side), LARGEST) for side in zip(*sizes, strict=True))
    nearest = all(grid.nearest for grid in grids)
    if resolution:
        width = height = resolution
    return TexelGrid(width, height, place, wrap, nearest)


def _texture_grid(texture: "mi.Texture") -> TexelGrid:
    """The grid of one texture."""
    parameters = mi.traverse(texture)
    place = IDENTITY
    if "to_uv" in parameters:
        matrix = np.asarray(parameters["to_uv"].matrix.numpy(), np.float64).reshape(3, 3)
        (a, b, c), (d, e, f) = matrix[:2].tolist()
        place = (a, b, c), (d, e, f)
    width, height = texture.resolution()
    if width * height <= 1:
        sharp = texture.class_name() == "Checkerboard"  # its edges fall between texels
        return TexelGrid(PROCEDURAL, PROCEDURAL, place, "repeat", sharp)
    return TexelGrid(width, height, place, *_addressing(texture, place, width, height))


def _addressing(texture: "mi.Texture", place: tuple, width: int, height: int) -> tuple[str, bool]:
    """Wrap mode of a bitmap beyond its unit square, and whether it is filtered by nearest texel.

    Detected from its values, because Mitsuba's bitmaps do not expose these properties.
    """
    rng = np.random.default_rng(0)
    size = np.array([width, height])
    texel = rng.integers(size, size=(POINTS, 2))
    inside = (texel + 0.5) / size
    outside = inside + 1
    mirrored, clamped = 1 - inside, np.broadcast_to(1 - 0.5 / size, inside.shape)
    shifted = (texel + 0.75) / size
    values = [
        _values(texture, from_texture(place, points))
        for points in (outside, inside, mirrored, clamped, shifted)
    ]
    error = [np.abs(values[0] - other).max() for other in values[1:4]]
    spread = max(np.ptp(values[1]), 1e-6)
    wrap = ("repeat", "mirror", "clamp")[int(np.argmin([max(e, 0.01 * spread) for e in error]))]
    nearest = bool(np.abs(values[4] - values[1]).max() < 1e-4 * spread)
    return wrap, nearest and np.ptp(values[1]) > 0


def _values(texture: "mi.Texture", uv: np.ndarray) -> np.ndarray:
    """The first channel of a texture (M,) at points uv (M, 2)."""
    si = spectrum.points(uv)
    try:
        value = spectrum.at_bands(si, lambda: spectrum.to_channels(texture.eval(si)))[0]
    except RuntimeError:  # some variants have no spectrum of three raw numbers
        value = texture.eval_3(si)[0]
    return np.broadcast_to(value.numpy(), len(uv)).astype(np.float64)
