"""Latent codes of a coat over a Mitsuba BSDF, constant or a texture.

Three stages: the codes of the bottom, the coat's parameters at every texel, and the layering. Each
stage remembers its inputs and repeats only the work for inputs that have changed. A textured bottom
is compared by a few probes of each texel: texels with equal hashes share their codes.
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
from urushi.textures.bake import TEXEL_BLOCK, CoatTexture
from urushi.textures.grid import TexelGrid
from urushi.textures.store import TextureStore

#: Texels that are probed at once: bounds memory.
PROBED_TEXELS = 1 << 13

#: Stride of the probe pairs by which texels are compared.
KEY_STRIDE = 24


class BottomCodes:
    """The codes of a bottom; `update` computes them, and computes them again after a change."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str):
        self._model, self._bottom, self._where = model, bottom, where
        self._grid: TexelGrid | None = None
        self._codes: np.ndarray | TextureStore = np.zeros((1, 1, 1), np.float32)
        self._keys = np.zeros((1, 1), np.uint64)

    def update(self, grid: TexelGrid | None) -> None:
        """Encode the bottom where it has changed since the last call with the same grid.

        Raises:
            ParameterError: a value of the bottom is negative or not finite.
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
        """Codes (C, size) of a constant bottom."""
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
    """Codes of a bottom that consists of codes itself."""

    def __init__(self, latents):
        self._latents = latents

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2)."""
        return texel_hash.row_hashes(list(np.moveaxis(self._latents.at(uv), -1, 0)))

    def codes(self, uv: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2)."""
        return self._latents.at(uv)


class _ProbedBottom:
    """Codes of a bottom that is evaluated at the probe pairs."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str, grid: TexelGrid):
        self._model, self._bottom, self._where = model, bottom, where
        self._pairs = model.networks.pairs()
        self._average = probing.needed_averaging(bottom, *self._pairs, grid, where)

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2): equal where the bottom is."""
        wi, wo = self._pairs
        if self._average.repeats > 1:  # values of a random BSDF cannot be compared
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
    """The codes of a coat over a bottom; `update` computes them, and again after a change."""

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
        """The codes for the current parameters; in a texture, only changed rows are layered.

        bottom_changed: whether the bottom may have changed since the last call.

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
            self._texture = CoatTexture(self._model, grid, spectrum.channel_count(), self._mipmaps)
        dr.sync_thread()  # kernels may still read what is overwritten here
        self._texture.update(
            lambda start, stop: self._coat.table(grid.uv(start, stop)), self._codes.read
        )
        return TexturedLatents(self._model, self._texture.store, grid)


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
    """Check the coat's parameters over uv; the walk clips the others at each point.

    Raises:
        ParameterError: one is out of range.
    """
    over_uv = {
        name: texture for name, texture in coat.textures.items() if not grids.not_over_uv(texture)
    }
    elsewhere = coat.textures.keys() - over_uv.keys()
    grid = grids.choose(over_uv, None, 0, coat.where)
    if grid is None:
        coat.table(np.full((1, 2), 0.5), elsewhere)
        return
    for start in range(0, grid.texels, TEXEL_BLOCK):
        coat.table(grid.uv(start, min(start + TEXEL_BLOCK, grid.texels)), elsewhere)
