"""A packed latent texture that is read and changed by rows, with or without a mip pyramid."""

import numpy as np

from urushi.nets.weights import Model
from urushi.textures import packing
from urushi.textures.mip_pyramid import coarse_levels, level_sizes
from urushi.textures.packing import PackedTexels, TexelLayout

#: Texels that are packed at once: bounds memory.
PACKED_BLOCK = 1 << 17


class TextureStore:
    """Codes of a texture's texels, row by row; the rows of its levels follow each other.

    Attributes:
        layout, packed: layout and bytes of the texels; none before the first writing, which
            chooses the layout.
        levels: width and height of every level.
    """

    def __init__(
        self, model: Model, layout: TexelLayout, width: int, height: int, *, mipmaps=False
    ):
        """mipmaps: whether to hold all levels of the mip pyramid; else the first one only."""
        self.layout, self._model = layout, model
        # Channels often share numbers of their lobes, which are compared one by one.
        self._compared = model.arch.lobe
        self.levels = level_sizes(width, height) if mipmaps else [(width, height)]
        nothing = np.zeros(layout.size, np.float32)
        self.packed = PackedTexels(np.zeros((0, layout.texel_bytes), np.uint8), nothing, nothing)

    def read(self, rows: slice | np.ndarray) -> np.ndarray:
        """Codes float32 (n, channels, size) of rows."""
        part = self.packed._replace(bytes=self.packed.bytes[rows])
        return packing.unpack(self.layout, part)

    def write(
        self, rows: slice | np.ndarray, codes: np.ndarray, index: np.ndarray | None = None
    ) -> None:
        """Set rows (n,) of the first level, and compute the other levels, layout and ranges.

        The first writing must set all rows.

        codes: (n, channels, size); or (k, size) codes that texels share, and index (n, channels)
            chooses the codes of each texel among them.
        """
        codes, first = codes.astype(np.float16, copy=False), self.levels[0][0] * self.levels[0][1]
        former = []
        if len(codes if index is None else index) < first:  # other texels keep their bits
            packed = self.packed
            former = [(packed.lowest, packed.lowest + self.layout.levels * packed.step)]
            starts = range(0, first, PACKED_BLOCK)
            blocks = [slice(start, min(start + PACKED_BLOCK, first)) for start in starts]
            whole = np.concatenate([self.read(block).astype(np.float16) for block in blocks])
            whole[rows] = codes if index is None else codes[index]
            codes, index = whole, None
        if index is None:
            texels, channels, size = codes.shape
            index = np.arange(texels * channels, dtype=np.uint32).reshape(texels, channels)
            codes = codes.reshape(-1, size)
        coarse = np.zeros((0, index.shape[1], codes.shape[-1]), np.float16)
        if len(self.levels) > 1:
            size = self.levels[0]
            found = coarse_levels(self._model, *size, lambda texels: codes[index[texels]])
            coarse = found.astype(np.float16)
        ends = [*former, *(_value_range(part) for part in (codes, coarse) if len(part))]
        lowest, highest = (np.stack(end) for end in zip(*ends, strict=True))
        lowest, highest = lowest.min(axis=0), highest.max(axis=0)
        same = _same_in_channels(codes, index, self._compared) & _equal_channels(coarse)
        self.layout = packing.texel_layout(
            self._model, self.layout.channels, lowest == highest, same
        )
        self.packed = packing.pack(self.layout, codes, index, coarse, lowest, highest)


def _same_in_channels(codes: np.ndarray, index: np.ndarray, compared: int) -> np.ndarray:
    """Whether numbers (size,) are the same in all channels; after `compared`, all or none are.

    codes: (k, size), chosen by index (n, channels).
    """
    differs = (index != index[:, :1]).any(axis=-1)
    same = np.full(codes.shape[-1], not differs.any())
    if differs.any():
        first = np.ascontiguousarray(codes[:, :compared])
        same[:compared] = _equal_channels(first[index[differs]])
    return same


def _equal_channels(codes: np.ndarray) -> np.ndarray:
    """Whether numbers (K,) of codes (n, channels, K) are the same in all channels."""
    return (codes == codes[:, :1]).all(axis=(0, 1))


def _value_range(whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest and the largest values float32 (size,) of codes (T, ..., size)."""
    starts, size = range(0, len(whole), PACKED_BLOCK), whole.shape[-1]
    blocks = (whole[k : k + PACKED_BLOCK].astype(np.float32).reshape(-1, size) for k in starts)
    ends = np.array([(block.min(axis=0), block.max(axis=0)) for block in blocks])
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
