"""Baking of a coat over a bottom into a latent texture, without a renderer.

A texel and channel is layered only if the coat's parameters or the bottom's code there have changed
since the last time, and texels of equal inputs are layered once.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.checks import CoatParameters
from urushi.material.layer import layer_texels
from urushi.nets.weights import Model
from urushi.textures import packing, texel_hash
from urushi.textures.grid import TexelGrid
from urushi.textures.store import TextureStore

#: Texels that are compared and layered at once: bounds memory.
TEXEL_BLOCK = 1 << 18

#: Gives the coat's parameters at texels start to stop - 1, arrays (n, 1 or C) by the names of
#: `layer_texels`; alpha may be `Widths`.
Table = Callable[[int, int], dict[str, Any]]

#: Gives the bottom at texels start to stop - 1: hashes uint64 (n or 1, C) and codes
#: (n or 1, C, size).
Bottom = Callable[[int, int], tuple[np.ndarray, np.ndarray]]


class CoatTexture:
    """The codes of a coat over a bottom on a grid of texels.

    Attributes:
        grid: the texels.
        store: their packed codes; empty before the first `update`.
    """

    def __init__(self, model: Model, grid: TexelGrid, channels: int, mipmaps: bool):
        """mipmaps: whether to hold all levels of the mip pyramid; else the first one only."""
        self.grid, self._model = grid, model
        self._hashes = np.zeros((grid.texels, channels), np.uint64)
        layout = packing.texel_layout(model, channels)
        self.store = TextureStore(model, layout, grid.width, grid.height, mipmaps=mipmaps)

    def update(self, table: Table, bottom: Bottom) -> None:
        """Layer the rows, one for each texel and channel, whose inputs have changed."""
        if self.store.empty:
            self._hashes[:] = 0  # an error ended the last attempt
        with self.store.writing() as write:
            for start in range(0, self.grid.texels, TEXEL_BLOCK):
                stop = min(start + TEXEL_BLOCK, self.grid.texels)
                parameters = CoatParameters(**table(start, stop))
                bottom_hashes, codes = bottom(start, stop)
                former = self._hashes[start:stop]
                hashes = np.broadcast_to(
                    texel_hash.row_hashes([bottom_hashes, *parameters.columns()]), former.shape
                )
                changed = hashes != former
                if not changed.any():
                    continue
                if changed.all():
                    write(slice(start, stop), *self._all_layered(hashes, parameters, codes))
                else:
                    texel, channel = np.nonzero(changed)
                    layered, row_of = self._layered(hashes, texel, channel, parameters, codes)
                    rows, index = np.unique(texel, return_inverse=True)
                    texels = self.store.read(start + rows)
                    texels[index, channel] = layered[row_of]
                    write(start + rows, texels)
                self._hashes[start:stop] = hashes

    def _all_layered(
        self, hashes: np.ndarray, parameters: CoatParameters, codes: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """Codes (n, C, size) of texels with hashes (n, C).

        Or distinct codes (k, size) of them, and which one each texel has (n, C).
        """
        row, row_of = texel_hash.unique_rows(hashes.ravel())
        if len(row) == hashes.size:  # nothing is shared, and nothing need be gathered
            return (layer_texels(self._model, codes, **parameters._asdict()),)
        texel, channel = np.divmod(row, hashes.shape[1])
        return self._layered_rows(texel, channel, parameters, codes), row_of.reshape(hashes.shape)

    def _layered(
        self,
        hashes: np.ndarray,
        texel: np.ndarray,
        channel: np.ndarray,
        parameters: CoatParameters,
        codes: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distinct codes (k, size) of rows (texel, channel), and the index (n,) of each row's."""
        row, row_of = texel_hash.unique_rows(hashes[texel, channel])
        return self._layered_rows(texel[row], channel[row], parameters, codes), row_of

    def _layered_rows(
        self,
        texel: np.ndarray,
        channel: np.ndarray,
        parameters: CoatParameters,
        codes: np.ndarray,
    ) -> np.ndarray:
        """Codes (k, size) of rows (texel, channel)."""

        def at_rows(array: np.ndarray) -> np.ndarray:
            count, width = array.shape[:2]
            return array[texel if count > 1 else 0, channel if width > 1 else 0]

        rows = [np.broadcast_to(at_rows(column), len(texel)) for column in parameters.columns()]
        coat = CoatParameters.of_columns(rows)
        return layer_texels(self._model, at_rows(codes), **coat._asdict())
