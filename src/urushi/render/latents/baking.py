"""The latent codes of a bottom, the same everywhere or texel by texel: the first stage of baking.

A textured bottom is probed where it is new only: a few probes tell each texel's key, texels of
equal keys have equal codes, and after a change those whose keys are as before keep theirs.

From a coat's parameters and the BSDF under it to latent codes, constant or a texture of them.

Three stages: the bottom's codes (`bottom_codes`), the coat's parameters at every texel, and the
layering of the one by the other. Each remembers what it was made from, and does only the rest when
it is asked again.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material.encode import encode_source, encoder_codes
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_texels
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.latents.holders import ConstantLatents, TexturedLatents
from urushi.render.reading import grid as grids
from urushi.render.reading import probing
from urushi.render.reading.bsdf import reflection_source
from urushi.render.reading.grid import varying_textures
from urushi.render.reading.parameters import CoatTextures, check_bottom
from urushi.textures import packing, texel_hash
from urushi.textures.grid import TexelGrid
from urushi.textures.store import TextureStore

#: Texels that are compared and encoded at once, and that are probed at once: both bound memory.
TEXEL_BLOCK, PROBED_TEXELS = 1 << 18, 1 << 13

#: Of the probe pairs, every so manieth tells a texel's key.
KEY_STRIDE = 24


class BottomCodes:
    """A bottom's codes; `update` makes them, and makes them anew after a change."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str):
        self._model, self._bottom, self._where = model, bottom, where
        self._grid: TexelGrid | None = None
        self._codes: np.ndarray | TextureStore = np.zeros((1, 1, 1), np.float32)
        self._keys = np.zeros((1, 1), np.uint64)

    def update(self, grid: TexelGrid | None) -> None:
        """Encode what is not as it was when this was last called, with the same grid.

        Raises:
            ParameterError: the bottom gives what no BRDF gives.
        """
        nested = nested_latents(self._bottom, self._model)
        if nested is not None and nested.resolution is None:
            self._keep_same(nested.at(np.full((1, 2), 0.5)))
        elif grid is not None and (nested is not None or varying_textures(self._bottom)):
            self._update_texels(grid, nested)
        else:
            self._keep_same(self._encoded()[None])

    def read(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Keys (n or 1, C) and codes (n or 1, C, size) of a range of texels."""
        if isinstance(self._codes, np.ndarray):
            return self._keys, self._codes
        return self._keys[start:stop], self._codes.read(slice(start, stop))

    def _encoded(self) -> np.ndarray:
        """Codes (C, size) of a bottom that is the same everywhere."""
        check_bottom(self._bottom, self._where)
        material, deviations = encode_source(
            reflection_source(self._bottom), self._model, name=f"{self._where}: the nested BSDF"
        )
        for sentence in deviations.warnings():
            mi.Log(mi.LogLevel.Warn, f"{self._where}: {sentence}")
        return material.anchors

    def _probed(self, grid: TexelGrid) -> "_ProbedBottom":
        return _ProbedBottom(self._model, self._bottom, self._where, grid)

    def _keep_same(self, codes: np.ndarray) -> None:
        """One code a channel, (1, C, size)."""
        self._codes, self._grid = codes, None
        self._keys = texel_hash.row_hashes(list(np.moveaxis(codes, -1, 0)))

    def _update_texels(self, grid: TexelGrid, nested) -> None:
        channels = spectrum.channel_count()
        if self._grid != grid:
            self._grid = grid
            layout = packing.texel_layout(self._model, channels)
            self._codes = TextureStore(self._model, layout, grid.width, grid.height)
            self._keys = np.zeros((grid.texels, channels), np.uint64)
        assert isinstance(self._codes, TextureStore)
        if self._codes.empty:
            self._keys[:] = 0  # an error ended the last attempt
        source = _NestedBottom(nested) if nested else self._probed(grid)
        with self._codes.writing() as write:
            for start in range(0, grid.texels, TEXEL_BLOCK):
                stop = min(start + TEXEL_BLOCK, grid.texels)
                uv = grid.uv(start, stop)
                present = source.keys(uv)
                rows = np.flatnonzero((present != self._keys[start:stop]).any(axis=1))
                if len(rows):
                    write(start + rows, source.codes(uv[rows], present[rows]))
                self._keys[start:stop] = present


def nested_latents(bottom: "mi.BSDF", model: Model):
    """The codes below a coat of a bottom that has codes of the same networks, or None."""
    nested = getattr(bottom, "latents", None)
    if nested is None or bottom.model.fingerprint != model.fingerprint:
        return None
    if nested.channels != spectrum.channel_count():
        return None
    return getattr(nested, "anchors", nested)


class _NestedBottom:
    """Codes that the bottom has already."""

    def __init__(self, latents):
        self._latents = latents

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2)."""
        return texel_hash.row_hashes(list(np.moveaxis(self._latents.at(uv), -1, 0)))

    def codes(self, uv: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2)."""
        return self._latents.at(uv)


class _ProbedBottom:
    """Codes from evaluating the bottom."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str, grid: TexelGrid):
        self._model, self._bottom, self._where = model, bottom, where
        self._pairs = model.networks.pairs()
        self._average = probing.needed_averaging(bottom, *self._pairs, grid, where)

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2): equal where the bottom is."""
        wi, wo = self._pairs
        if self._average.repeats > 1:  # it draws random numbers: what it gives tells nothing
            shape = len(uv), spectrum.channel_count()
            return np.random.default_rng().integers(1 << 63, size=shape).astype(np.uint64)
        f = probing.texel_values(
            self._bottom, wi[::KEY_STRIDE], wo[::KEY_STRIDE], uv, probing.Averaging()
        )
        return texel_hash.row_hashes(list(np.moveaxis(f, -1, 0)))

    def codes(self, uv: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2) with keys (M, C)."""
        channels = present.shape[1]
        texel, texel_of = texel_hash.unique_rows(texel_hash.row_hashes(list(present.T)))
        row, row_of = texel_hash.unique_rows(present[texel].ravel())
        parts = []
        for start in range(0, len(texel), PROBED_TEXELS):
            points = uv[texel[start : start + PROBED_TEXELS]]
            f = probing.texel_values(self._bottom, *self._pairs, points, self._average)
            f = probing.check_values(f, self._where).reshape(len(points) * channels, -1)
            first = start * channels
            own = row[slice(*np.searchsorted(row, [first, first + len(f)]))]
            parts.append(encoder_codes(self._model, f[own - first]))
        codes = limit_albedo(self._model, np.concatenate(parts))
        return codes[row_of].reshape(len(texel), channels, -1)[texel_of]


class Baker:
    """A coat over a bottom as latent codes; `update` makes them, and makes them anew."""

    def __init__(
        self,
        model: Model,
        coat: CoatTextures,
        bottom: "mi.BSDF",
        resolution: int,
        mipmaps: bool = False,
    ):
        """Prepare a coat; nothing is evaluated before `update`.

        resolution: texels per side of a latent texture, 0 to choose.
        mipmaps: whether a latent texture has a mip pyramid.
        """
        self._model, self._coat, self._bottom = model, coat, bottom
        self._resolution, self._mipmaps = resolution, mipmaps
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
            self._texture = CoatTexture(self._model, self._coat, grid, self._mipmaps)
        return self._texture.update(self._codes)


class CoatTexture:
    """A texture of coats over a bottom: the packed codes, and the keys of what they are made of."""

    def __init__(self, model: Model, coat: CoatTextures, grid: TexelGrid, mipmaps: bool):
        self.grid = grid
        self._model, self._coat = model, coat
        self._keys = np.zeros((grid.texels, spectrum.channel_count()), np.uint64)
        layout = packing.texel_layout(model, self._keys.shape[1])
        self._store = TextureStore(model, layout, grid.width, grid.height, mipmaps=mipmaps)

    def update(self, bottom: BottomCodes) -> TexturedLatents:
        """Layer the rows, one a texel and channel, whose coat or bottom is not as before."""
        grid = self.grid
        dr.sync_thread()  # kernels may still read what is overwritten here
        if self._store.empty:
            self._keys[:] = 0  # an error ended the last attempt
        with self._store.writing() as write:
            for start in range(0, grid.texels, TEXEL_BLOCK):
                stop = min(start + TEXEL_BLOCK, grid.texels)
                table = self._coat.table(grid.uv(start, stop))
                under, codes = bottom.read(start, stop)
                before = self._keys[start:stop]
                present = np.broadcast_to(
                    texel_hash.row_hashes([under, *table.values()]), before.shape
                )
                texel, channel = np.nonzero(present != before)
                if not len(texel):
                    continue
                layered, row_of = self._layered(present, texel, channel, table, codes)
                if len(row_of) == present.size:
                    write(np.arange(start, stop), layered, row_of.reshape(present.shape))
                else:
                    rows, which = np.unique(texel, return_inverse=True)
                    texels = self._store.read(start + rows)
                    texels[which, channel] = layered[row_of]
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
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distinct codes (k, size) of rows (texel, channel), and the code of each row (n,)."""
        row, row_of = texel_hash.unique_rows(present[texel, channel])
        texel, channel = texel[row], channel[row]

        def at_rows(array: np.ndarray) -> np.ndarray:
            count, width = array.shape[:2]
            return array[texel if count > 1 else 0, channel if width > 1 else 0]

        rows = {name: np.broadcast_to(at_rows(v), len(row)) for name, v in table.items()}
        return layer_texels(self._model, at_rows(codes), **rows), row_of


def choose_grid(
    coat: CoatTextures, bottom: "mi.BSDF", model: Model, resolution: int
) -> TexelGrid | None:
    """The grid of a coat's codes over a bottom; None: they are the same everywhere.

    Raises:
        ParameterError: a texture is not over uv, or the bottom has normals of its own.
    """
    grids.check_normals(bottom, coat.where)
    nested = nested_latents(bottom, model)
    below = {} if nested is not None else {"the nested BSDF": bottom}
    inner = nested.grid if nested is not None else None
    return grids.choose({**coat.textures, **below}, inner, resolution, coat.where)


def check(coat: CoatTextures) -> None:
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
    for start in range(0, grid.texels, TEXEL_BLOCK):
        coat.table(grid.uv(start, min(start + TEXEL_BLOCK, grid.texels)), unknown)
