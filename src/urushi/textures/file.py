"""The file of a latent texture: its packed texels, level by level, and where they lie in uv."""

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.material.file import belonging
from urushi.nets.weights import Model
from urushi.textures import mip_pyramid
from urushi.textures.packing import Layout, Packed
from urushi.textures.store import TextureStore

#: Files of version 1 have no entry `levels`; they hold all levels of the mip pyramid.
KIND, FORMAT_VERSION = "texture", 2

#: How a texture goes on beyond its unit square.
WRAPS = ("repeat", "mirror", "clamp")


class Place(NamedTuple):
    """Where a texture's texels lie.

    Attributes:
        to_texture: the affine map (2, 3) from uv to the unit square of texels, as nested tuples.
        wrap: one of `WRAPS`.
        nearest: whether the nearest texel is taken as it is, without interpolation.
    """

    to_texture: tuple
    wrap: str
    nearest: bool


def write(path: str | os.PathLike, store: TextureStore, place: Place, fingerprint: str) -> None:
    """Write a texture whose codes belong to the networks of `fingerprint`.

    Raises:
        FileError: the file cannot be written.
    """
    width, height = store.levels[0]
    description = {
        "version": FORMAT_VERSION,
        "weights": fingerprint,
        "width": width,
        "height": height,
        "levels": len(store.levels),
        "layout": store.layout._asdict(),
        "place": place._asdict(),
    }
    packed = store.packed
    arrays = {"texels": packed.bytes, "lowest": packed.lowest, "step": packed.step}
    files.write_tensors(path, KIND, description, arrays)


def read(path: str | os.PathLike, models: Sequence[Model]) -> tuple[TextureStore, Place, Model]:
    """Return a file's texture, its place, and which of some networks it was made with.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, KIND)
    if description.get("version") not in (1, FORMAT_VERSION):
        raise FileError(
            f"'{path}' has version {description.get('version')!r} of the texture format, "
            f"this Urushi reads versions 1 and {FORMAT_VERSION}; install the Urushi that wrote it"
        )
    model = belonging(path, description.get("weights"), models)
    try:
        store = _store(description, arrays, model)
        place = _place(description["place"])
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return store, place, model


def _store(
    description: dict[str, Any], arrays: dict[str, np.ndarray], model: Model
) -> TextureStore:
    entries = description["layout"]
    layout = Layout(**{**entries, "low": tuple(int(byte) for byte in entries["low"])})
    size, count = model.arch.latent, layout.texel_bytes
    places = [byte for byte in layout.low if byte >= 0]
    fits = 0 < layout.channels * layout.stride <= count and count % 4 == 0
    if not fits or (layout.size, len(layout.low)) != (size, size):
        raise ValueError("its layout is not that of these networks")
    if count.bit_count() != 1 or any(not size <= byte < layout.stride for byte in places):
        raise ValueError("its layout is impossible")
    width, height = int(description["width"]), int(description["height"])
    if width < 1 or height < 1:
        raise ValueError("it has no texels")
    every_level = len(mip_pyramid.level_sizes(width, height))
    levels = every_level if description["version"] == 1 else description["levels"]
    if levels not in (1, every_level):
        raise ValueError(f"it has {levels!r} levels, not 1 or {every_level}")
    store = TextureStore(model, layout, width, height, mipmaps=levels > 1)
    shape = sum(w * h for w, h in store.levels), count
    packed = Packed(arrays["texels"], arrays["lowest"], arrays["step"])
    if packed.bytes.dtype != np.uint8 or packed.bytes.shape != shape:
        raise ValueError("texels are missing")
    for range_ in (packed.lowest, packed.step):
        wrong = range_.dtype != np.float32 or range_.shape != (size,)
        if wrong or not np.isfinite(range_).all():
            raise ValueError("its ranges are no finite numbers")
    store.packed = packed
    return store


def _place(entries: dict[str, Any]) -> Place:
    matrix = np.array(entries["to_texture"], np.float64)
    if matrix.shape != (2, 3) or not np.isfinite(matrix).all() or entries["wrap"] not in WRAPS:
        raise ValueError("its place in uv is unknown")
    (a, b, c), (d, e, f) = matrix.tolist()
    return Place(((a, b, c), (d, e, f)), entries["wrap"], bool(entries["nearest"]))
