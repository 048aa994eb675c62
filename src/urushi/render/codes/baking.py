"""From a coat's parameters and the BSDF under it to latent codes, constant or a texture of them.

Three stages: the bottom's codes (`bottom_codes`), the coat's parameters at every texel, and the
layering of the one by the other. Each remembers what it was made from, and does only the rest when
it is asked again.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import keys, packing
from urushi.material.store import Store
from urushi.material.texture import layer_texels
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.codes.bottom_codes import TEXELS, BottomCodes, nested_latents
from urushi.render.codes.latents import ConstantLatents, TexturedLatents
from urushi.render.reading import grid as grids
from urushi.render.reading.grid import Grid
from urushi.render.reading.parameters import CoatParameters


class Baker:
    """A coat over a bottom as latent codes; `update` makes them, and makes them anew."""

    def __init__(self, model: Model, coat: CoatParameters, bottom: "mi.BSDF", resolution: int):
        """resolution: texels per side of a latent texture, 0 to choose."""
        self._model, self._coat, self._bottom = model, coat, bottom
        self._resolution = resolution
        self._codes = BottomCodes(model, bottom, coat.where)
        self._texture: CoatTexture | None = None

    def update(self, bottom_changed: bool = True) -> ConstantLatents | TexturedLatents:
        """The codes of the parameters as they are now; of a texture, only new rows are layered.

        bottom_changed: whether the bottom may be another than when this was last called.

        Raises:
            ParameterError: a parameter is out of range, or the bottom gives what no BRDF gives.
        """
        grid = choose_grid(self._coat, self._bottom, self._model, self._resolution)
        before = self._texture and self._texture.grid
        if bottom_changed or grid != before:
            self._codes.update(grid)
        if grid is None:
            self._texture = None
            table = self._coat.table(np.full((1, 2), 0.5))
            return ConstantLatents(
                self._model, layer_texels(self._model, self._codes.read(0, 1)[1], **table)[0]
            )
        if self._texture is None or grid != before:
            self._texture = CoatTexture(self._model, self._coat, grid)
        return self._texture.update(self._codes)


class CoatTexture:
    """A texture of coats over a bottom: the packed codes, and the keys of what they are made of."""

    def __init__(self, model: Model, coat: CoatParameters, grid: Grid):
        self.grid = grid
        self._model, self._coat = model, coat
        self._keys = np.zeros((grid.texels, spectrum.channel_count()), np.uint64)
        layout = packing.layout(model, self._keys.shape[1])
        self._store = Store(model, layout, grid.width, grid.height, mipped=True)

    def update(self, bottom: BottomCodes) -> TexturedLatents:
        """Layer the rows, one a texel and channel, whose coat or bottom is not as before."""
        grid = self.grid
        dr.sync_thread()  # kernels may still read what is overwritten here
        if self._store.empty:
            self._keys[:] = 0  # an error ended the last attempt
        with self._store.writing() as write:
            for start in range(0, grid.texels, TEXELS):
                stop = min(start + TEXELS, grid.texels)
                table = self._coat.table(grid.uv(start, stop))
                under, codes = bottom.read(start, stop)
                before = self._keys[start:stop]
                present = np.broadcast_to(keys.of([under, *table.values()]), before.shape)
                texel, channel = np.nonzero(present != before)
                if not len(texel):
                    continue
                layered = self._layered(present, texel, channel, table, codes)
                if len(layered) == present.size:
                    write(np.arange(start, stop), layered.reshape(*present.shape, -1))
                else:
                    rows, which = np.unique(texel, return_inverse=True)
                    texels = self._store.read(start + rows)
                    texels[which, channel] = layered
                    write(start + rows, texels)
                self._keys[start:stop] = present
        return TexturedLatents(self._model, self._store, grid)

    def _layered(
        self,
        present: np.ndarray,
        texel: np.ndarray,
        channel: np.ndarray,
        table: dict[str, np.ndarray],
        codes: np.ndarray,
    ) -> np.ndarray:
        """Codes (n, size) of rows (texel, channel), each of those that are alike once."""
        row, row_of = keys.distinct(present[texel, channel])
        texel, channel = texel[row], channel[row]

        def at_rows(array: np.ndarray) -> np.ndarray:
            count, width = array.shape[:2]
            return array[texel if count > 1 else 0, channel if width > 1 else 0]

        rows = {name: np.broadcast_to(at_rows(v), len(row)) for name, v in table.items()}
        return layer_texels(self._model, at_rows(codes), **rows)[row_of]


def choose_grid(
    coat: CoatParameters, bottom: "mi.BSDF", model: Model, resolution: int
) -> Grid | None:
    """The grid of a coat's codes over a bottom; None: they are the same everywhere.

    Raises:
        ParameterError: a texture is not over uv, or the bottom has normals of its own.
    """
    grids.check_normals(bottom, coat.where)
    nested = nested_latents(bottom, model)
    below = {} if nested is not None else {"the nested BSDF": bottom}
    inner = nested.grid if nested is not None else None
    return grids.choose({**coat.textures, **below}, inner, resolution, coat.where)


def check(coat: CoatParameters) -> None:
    """Look at the coat's parameters all over uv; what is not over uv, the walk clips at each point.

    Raises:
        ParameterError: one is out of range.
    """
    known = {
        name: texture for name, texture in coat.textures.items() if not grids.not_over_uv(texture)
    }
    unknown = coat.textures.keys() - known.keys()
    grid = grids.choose(known, None, 0, coat.where)
    if grid is None:
        coat.table(np.full((1, 2), 0.5), unknown)
        return
    for start in range(0, grid.texels, TEXELS):
        coat.table(grid.uv(start, min(start + TEXELS, grid.texels)), unknown)
