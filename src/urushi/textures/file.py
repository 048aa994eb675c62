"""The file of a latent texture: its packed texels, level by level, and its grid over uv."""

import json
import os
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.nets.weights import Model, model_of_file
from urushi.textures.grid import TexelGrid
from urushi.textures.packing import PackedTexels, TexelLayout
from urushi.textures.store import TextureStore

KIND, FORMAT_VERSION = "texture", 3


def write(path: str | os.PathLike, store: TextureStore, grid: TexelGrid, fingerprint: str) -> None:
    """Write a texture over `grid` that the networks with this fingerprint have made."""
    packed = store.packed
    description = {
        "version": FORMAT_VERSION,
        "weights": fingerprint,
        "width": grid.width,
        "height": grid.height,
        "levels": len(store.levels),
        "layout": store.layout._asdict(),
        "place": {"to_texture": grid.to_texture, "wrap": grid.wrap, "nearest": grid.nearest},
    }
    description["checksum"] = _checksum(description, packed)
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
        del description["kind"]
        packed = PackedTexels(arrays["texels"], arrays["lowest"], arrays["step"])
        checksum = description.pop("checksum")
        if checksum != _checksum(description, packed):
            raise ValueError("its content has changed")
        entries: dict[str, Any] = {
            n: tuple(x) if isinstance(x, list) else x for n, x in description["layout"].items()
        }
        place, size = description["place"], (description["width"], description["height"])
        place["to_texture"] = tuple(map(tuple, place["to_texture"]))
        mipmaps, grid = description["levels"] > 1, TexelGrid(*size, **place)
        store = TextureStore(model, TexelLayout(**entries), *size, mipmaps=mipmaps)
        store.packed = packed
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return store, grid, model


def _checksum(description: Mapping[str, Any], packed: PackedTexels) -> int:
    checksum = zlib.crc32(json.dumps(description, sort_keys=True).encode())
    for array in packed:
        checksum = zlib.crc32(np.ascontiguousarray(array).data, checksum)
    return checksum
