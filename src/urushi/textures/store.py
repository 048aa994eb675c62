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

#: Texture space equal to uv.
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


class TexelGrid(NamedTuple):
    """Texels over the unit square of texture space."""

    width: int
    height: int
    # The affine map (2, 3) from uv to texture space.
    to_texture: tuple[tuple[float, float, float], tuple[float, float, float]] = IDENTITY
    wrap: str = "repeat"  # beyond the unit square: "repeat", "mirror" or "clamp"
    nearest: bool = False  # whether a look-up returns the nearest texel instead of interpolating

    @property
    def texels(self) -> int:
        """Number of texels."""
        return self.width * self.height

    def uv(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """The uv (M, 2) of the centres of texels start to stop - 1, in row-major order."""
        index = np.arange(start, self.texels if stop is None else stop)
        x = (index % self.width + 0.5) / self.width
        y = (index // self.width + 0.5) / self.height
        return from_texture(self.to_texture, np.stack([x, y], axis=-1))


#: The grid of what is the same everywhere.
ONE_TEXEL = TexelGrid(1, 1)


def from_texture(to_texture: tuple, points: np.ndarray) -> np.ndarray:
    """The uv (M, 2) of points of texture space (M, 2)."""
    if to_texture == IDENTITY:
        return points
    matrix = np.array(to_texture)
    return np.linalg.solve(matrix[:, :2], (points - matrix[:, 2]).T).T


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
        "place": {"to_texture": grid.to_texture, "wrap": grid.wrap, "nearest": grid.nearest},
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
        place = description["place"]
        place["to_texture"] = tuple(map(tuple, place["to_texture"]))
        grid = TexelGrid(description["width"], description["height"], **place)
        texture = Texture(TexelLayout(**entries), *(arrays[name] for name in ARRAYS))
        if min(grid.width, grid.height) < 1 or len(texture.bytes) != grid.texels:
            raise ValueError(f"its {len(texture.bytes)} texels do not fill its grid")
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return texture, grid, model


def _checksum(description: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> int:
    checksum = zlib.crc32(json.dumps(description, sort_keys=True).encode())
    for name in ARRAYS:
        checksum = zlib.crc32(np.ascontiguousarray(arrays[name]).data, checksum)
    return checksum
