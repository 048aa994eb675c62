"""The grid of a latent texture's texels over uv, and its file."""

import json
import os
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.nets.weights import Model, model_of_file
from urushi.textures.packing import TexelLayout, Texture

#: Kind of the files of textures, and its version.
KIND, FORMAT_VERSION = "texture", 4

#: Names in files of the arrays of a `Texture`.
ARRAYS = ("texels", "lowest", "step")

#: Largest number of codes in a texel of a file.
MOST_CHANNELS = 64

#: The place of texels in files: over the unit square of uv, which repeats.
PLACE = {"to_texture": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "wrap": "repeat", "nearest": False}


class TexelGrid(NamedTuple):
    """Texels over the unit square of uv, which repeats."""

    width: int
    height: int

    @property
    def texels(self) -> int:
        """Number of texels."""
        return self.width * self.height

    def uv(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """The uv (M, 2) of the centres of texels start to stop - 1, in row-major order."""
        index = np.arange(*slice(start, stop).indices(self.texels))
        places = np.stack([index % self.width, index // self.width], axis=-1)
        return (places + 0.5) / (self.width, self.height)


#: The grid of what is the same everywhere.
ONE_TEXEL = TexelGrid(1, 1)


def write_texture(
    path: str | os.PathLike, texture: Texture, grid: TexelGrid, fingerprint: str
) -> None:
    """Write a texture over `grid` that the weights with this fingerprint have made."""
    description = {
        "version": FORMAT_VERSION,
        "weights": fingerprint,
        "width": grid.width,
        "height": grid.height,
        "layout": texture.layout._asdict(),
        "place": PLACE,
    }
    arrays = dict(zip(ARRAYS, texture[1:], strict=True))
    description["checksum"] = _checksum(description, arrays)
    files.write_tensors(path, KIND, description, arrays)


def read_texture(
    path: str | os.PathLike, model: Model | None = None
) -> tuple[Texture, TexelGrid, Model]:
    """Return a file's texture, its grid, and the weights that it was made with.

    model: the weights; None: the shipped ones by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other weights.
    """
    description, arrays = files.read_tensors(path, KIND, FORMAT_VERSION)
    model = model_of_file(path, description.get("weights"), model)
    try:
        del description["kind"]
        if description.pop("checksum") != _checksum(description, arrays):
            raise ValueError("its content has changed")
        entries: dict[str, Any] = {
            n: tuple(x) if isinstance(x, list) else x for n, x in description["layout"].items()
        }
        if description["place"] != PLACE:
            raise ValueError("its texels are not over the unit square of uv")
        grid = TexelGrid(description["width"], description["height"])
        texture = Texture(TexelLayout(**entries), *(arrays[name] for name in ARRAYS))
        if min(grid.width, grid.height) < 1 or len(texture.bytes) != grid.texels:
            raise ValueError(f"its {len(texture.bytes)} texels do not fill its grid")
        _check(texture, grid, model)
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return texture, grid, model


def _check(texture: Texture, grid: TexelGrid, model: Model) -> None:
    """Raise ValueError unless a texture has a valid layout for codes of a model, and fits it."""
    layout, size = texture.layout, model.arch.latent
    numbers = (layout.channels, layout.size, layout.shared, layout.stride, layout.texel_bytes)
    places = (*layout.high, *layout.low)
    if not all(type(x) is int for x in (*grid, *numbers, *places)):
        raise ValueError("its sizes or places are not whole numbers")
    lengths = {len(part) for part in (layout.high, layout.low, layout.same)}
    ends = [(layout.shared if same else layout.stride) for same in layout.same] * 2
    if (
        (layout.size, lengths) != (size, {size})
        or not 1 <= layout.channels <= MOST_CHANNELS
        or min(layout.shared, layout.stride) < 0
        or not all(-1 <= place < end for place, end in zip(places, ends, strict=True))
        or layout.used_bytes > layout.texel_bytes
    ):
        raise ValueError(f"its layout is not one of codes of {size} numbers")
    for array, dtype, shape in (
        (texture.bytes, np.uint8, (len(texture.bytes), layout.texel_bytes)),
        (texture.lowest, np.float32, (size,)),
        (texture.step, np.float32, (size,)),
    ):
        if array.dtype != dtype or array.shape != shape or not np.isfinite(array).all():
            raise ValueError("its arrays do not have the types and shapes of its layout")


def _checksum(description: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> int:
    checksum = zlib.crc32(json.dumps(description, sort_keys=True).encode())
    for name in ARRAYS:
        checksum = zlib.crc32(np.ascontiguousarray(arrays[name]).data, checksum)
    return checksum
