"""The file of a latent texture: its packed texels, level by level, and its grid over uv."""

import os
import zlib
from typing import Any

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.nets.weights import Model, model_of_file
from urushi.textures import mip_pyramid
from urushi.textures.grid import WRAPS, TexelGrid
from urushi.textures.packing import PackedTexels, TexelLayout
from urushi.textures.store import TextureStore

KIND, FORMAT_VERSION = "texture", 3


def write(path: str | os.PathLike, store: TextureStore, grid: TexelGrid, fingerprint: str) -> None:
    """Write a texture over `grid` that the networks with this fingerprint have made.

    Raises:
        FileError: the file cannot be written.
    """
    packed = store.packed
    description = {
        "version": FORMAT_VERSION,
        "weights": fingerprint,
        "width": grid.width,
        "height": grid.height,
        "levels": len(store.levels),
        "layout": store.layout._asdict(),
        "place": {"to_texture": grid.to_texture, "wrap": grid.wrap, "nearest": grid.nearest},
        "checksum": _checksum(packed),
    }
    arrays = {"texels": packed.bytes, "lowest": packed.lowest, "step": packed.step}
    files.write_tensors(path, KIND, description, arrays)


def read(
    path: str | os.PathLike, model: Model | None = None
) -> tuple[TextureStore, TexelGrid, Model]:
    """Return a file's texture, its grid, and the networks that it was made with.

    model: the networks; None: the shipped ones by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, KIND, FORMAT_VERSION)
    model = model_of_file(path, description.get("weights"), model)
    try:
        store = _store(description, arrays, model)
        grid = _checked_grid(*store.levels[0], description["place"])
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return store, grid, model


def _store(
    description: dict[str, Any], arrays: dict[str, np.ndarray], model: Model
) -> TextureStore:
    layout = _layout(description["layout"])
    size, count = model.arch.latent, layout.texel_bytes
    fits = 0 <= layout.used_bytes <= count and count % 4 == 0
    lengths = {len(layout.high), len(layout.low), len(layout.same), layout.size}
    if not fits or lengths != {size}:
        raise ValueError("its layout does not match these networks")
    if count.bit_count() != 1 or layout.channels < 1 or not _possible(layout):
        raise ValueError("its layout is impossible")
    width, height = int(description["width"]), int(description["height"])
    if width < 1 or height < 1:
        raise ValueError("it has no texels")
    every_level = len(mip_pyramid.level_sizes(width, height))
    levels = description["levels"]
    if levels not in (1, every_level):
        raise ValueError(f"it has {levels!r} levels, not 1 or {every_level}")
    store = TextureStore(model, layout, width, height, mipmaps=levels > 1)
    shape = sum(w * h for w, h in store.levels), count
    packed = PackedTexels(arrays["texels"], arrays["lowest"], arrays["step"])
    if packed.bytes.dtype != np.uint8 or packed.bytes.shape != shape:
        raise ValueError("texels are missing")
    if description.get("checksum", checksum := _checksum(packed)) != checksum:
        raise ValueError("its texels have changed")
    for range_ in (packed.lowest, packed.step):
        wrong = range_.dtype != np.float32 or range_.shape != (size,)
        if wrong or not np.isfinite(range_).all():
            raise ValueError("its ranges are not finite numbers")
    store.packed = packed
    return store


def _checksum(packed: PackedTexels) -> int:
    return zlib.crc32(np.ascontiguousarray(packed.bytes).data)


def _layout(entries: dict[str, Any]) -> TexelLayout:
    """The layout that a file describes."""
    return TexelLayout(
        channels=int(entries["channels"]),
        size=int(entries["size"]),
        high=tuple(int(byte) for byte in entries["high"]),
        low=tuple(int(byte) for byte in entries["low"]),
        same=tuple(bool(value) for value in entries["same"]),
        shared=int(entries["shared"]),
        stride=int(entries["stride"]),
        texel_bytes=int(entries["texel_bytes"]),
    )


def _possible(layout: TexelLayout) -> bool:
    """Whether every byte of the two kinds of parts of a texel holds one number at most."""
    for same, length in ((True, layout.shared), (False, layout.stride)):
        of_part = [number for number in range(layout.size) if layout.same[number] == same]
        places = [places[number] for places in (layout.high, layout.low) for number in of_part]
        used = [place for place in places if place >= 0]
        if len(set(used)) < len(used) or any(place >= length for place in used):
            return False
    return all(high >= 0 or low < 0 for high, low in zip(layout.high, layout.low, strict=True))


def _checked_grid(width: int, height: int, entries: dict[str, Any]) -> TexelGrid:
    matrix = np.array(entries["to_texture"], np.float64)
    if matrix.shape != (2, 3) or not np.isfinite(matrix).all() or entries["wrap"] not in WRAPS:
        raise ValueError("its place in uv is missing or wrong")
    (a, b, c), (d, e, f) = matrix.tolist()
    matrix_rows = (a, b, c), (d, e, f)
    return TexelGrid(width, height, matrix_rows, entries["wrap"], bool(entries["nearest"]))
