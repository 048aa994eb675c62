"""A latent texture: its grid of texels over uv, its packed codes, and its file.

The codes are read and changed by rows, one for each texel.
"""

import json
import os
import zlib
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.nets.weights import Model, model_of_file
from urushi.textures import packing
from urushi.textures.packing import PackedTexels, TexelLayout

#: Kind of the files of textures, and its version.
KIND, FORMAT_VERSION = "texture", 4

#: Texels that are packed at once: bounds memory.
PACKED_BLOCK = 1 << 17

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
MIDDLE = TexelGrid(1, 1)


def from_texture(to_texture: tuple, points: np.ndarray) -> np.ndarray:
    """The uv (M, 2) of points of texture space (M, 2)."""
    if to_texture == IDENTITY:
        return points
    matrix = np.array(to_texture)
    return np.linalg.solve(matrix[:, :2], (points - matrix[:, 2]).T).T


class TextureStore:
    """Codes of a texture's texels, row by row.

    There are none before the first writing, which chooses their layout.
    """

    def __init__(self, model: Model, channels: int, texels: int):
        """Make an empty texture of a number of texels, with so many codes of the model in each."""
        self._model, self._texels = model, texels
        self.layout = packing.texel_layout(channels, np.zeros(model.arch.latent))
        # Channels often share numbers of their lobes, which are compared one by one.
        self._compared = model.arch.lobe
        nothing = np.zeros(self.layout.size, np.float32)
        empty = np.zeros((0, self.layout.texel_bytes), np.uint8)
        self.packed = PackedTexels(empty, nothing, nothing)

    def read(self, rows: slice | np.ndarray) -> np.ndarray:
        """Codes float32 (n, channels, size) of rows."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack(self.layout, part)

    def write(
        self, rows: slice | np.ndarray, codes: np.ndarray, index: np.ndarray | None = None
    ) -> None:
        """Set rows (n,), and compute layout and ranges.

        The first writing must set all rows.

        codes: (n, channels, size); or (k, size) codes that texels share, and index (n, channels)
            chooses the codes of each texel among them.
        """
        codes = codes.astype(np.float32, copy=False)
        former, fine = [], list[int]()
        if len(codes if index is None else index) < self._texels:  # the others keep their bits
            packed = self.packed
            fine = [number for number, low in enumerate(self.layout.low) if low >= 0]
            former = [(packed.lowest, packed.lowest + self.layout.levels * packed.step)]
            starts = range(0, self._texels, PACKED_BLOCK)
            whole = np.concatenate([self.read(slice(k, k + PACKED_BLOCK)) for k in starts])
            whole[rows] = codes if index is None else codes[index]
            codes, index = whole, None
        if index is None:
            texels, channels, size = codes.shape
            index = np.arange(texels * channels, dtype=np.uint32).reshape(texels, channels)
            codes = codes.reshape(-1, size)
        ends = [*former, _value_range(codes)]
        lowest, highest = (np.stack(end) for end in zip(*ends, strict=True))
        lowest, highest = lowest.min(axis=0), highest.max(axis=0)
        same = _same_in_channels(codes, index, self._compared)
        errors = packing.rounding_errors(
            partial(packing.log_values, self._model), codes, lowest, highest
        )
        self.layout = packing.texel_layout(
            self.layout.channels, errors, lowest == highest, same, fine
        )
        self.packed = packing.pack(self.layout, codes, index, lowest, highest)


def _same_in_channels(codes: np.ndarray, index: np.ndarray, compared: int) -> np.ndarray:
    """Whether numbers (size,) are the same in all channels; after `compared`, all or none are.

    codes: (k, size), chosen by index (n, channels).
    """
    same = np.full(codes.shape[-1], (index == index[:, :1]).all())
    if not same.all():
        same[:compared] = codes[:, :compared].min(axis=0) == codes[:, :compared].max(axis=0)
        for i in np.flatnonzero(~same[:compared]):
            number = np.ascontiguousarray(codes[:, i])[index]
            same[i] = (number == number[:, :1]).all()
    return same


def _value_range(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest values float32 (size,) of codes (T, ..., size)."""
    starts, size = range(0, len(whole), PACKED_BLOCK), whole.shape[-1]
    blocks = (whole[k : k + PACKED_BLOCK].astype(np.float32).reshape(-1, size) for k in starts)
    ends = np.array([(block.min(axis=0), block.max(axis=0)) for block in blocks])
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)


def write_texture(
    path: str | os.PathLike, store: TextureStore, grid: TexelGrid, fingerprint: str
) -> None:
    """Write a texture over `grid` that the weights with this fingerprint have made."""
    packed = store.packed
    description = {
        "version": FORMAT_VERSION,
        "weights": fingerprint,
        "width": grid.width,
        "height": grid.height,
        "layout": store.layout._asdict(),
        "place": {"to_texture": grid.to_texture, "wrap": grid.wrap, "nearest": grid.nearest},
    }
    description["checksum"] = _checksum(description, packed)
    arrays = {"texels": packed.bytes, "lowest": packed.lowest, "step": packed.step}
    files.write_tensors(path, KIND, description, arrays)


def read_texture(
    path: str | os.PathLike, model: Model | None = None
) -> tuple[TextureStore, TexelGrid, Model]:
    """Return a file's texture, its grid, and the weights that it was made with.

    model: the weights; None: the shipped ones by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other weights.
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
        place = description["place"]
        place["to_texture"] = tuple(map(tuple, place["to_texture"]))
        grid = TexelGrid(description["width"], description["height"], **place)
        store = TextureStore(model, entries["channels"], grid.texels)
        store.layout, store.packed = TexelLayout(**entries), packed
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"the texture file '{path}' is damaged ({error}); save it again") from error
    return store, grid, model


def _checksum(description: Mapping[str, Any], packed: PackedTexels) -> int:
    checksum = zlib.crc32(json.dumps(description, sort_keys=True).encode())
    for array in packed:
        checksum = zlib.crc32(np.ascontiguousarray(array).data, checksum)
    return checksum
