"""Latent codes of the bottom of a coat, a Mitsuba BSDF that is constant or textured.

A textured bottom that is known by its values is compared by a few probes of each texel: texels with
equal hashes share their codes.
"""

import mitsuba as mi
import numpy as np

from urushi.material.encode import (
    bare_anchors,
    encode_source,
    encoder_codes,
    without_useless_rests,
)
from urushi.material.energy import limit_albedo, limit_mean_albedo
from urushi.material.material import Material
from urushi.material.table import node_pairs, table_of_values
from urushi.nets.lobe import no_lobe, with_two_widths
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.reading import probing
from urushi.render.reading.bsdf import reflection_source
from urushi.render.reading.grid import varying_textures
from urushi.render.reading.parameters import check_bottom
from urushi.render.reading.surfaces import KnownSurface, known_surface
from urushi.textures import packing, texel_hash
from urushi.textures.bake import TEXEL_BLOCK
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
        self._codes: np.ndarray | TextureStore | _BareBottom = np.zeros((1, 1, 1), np.float32)
        self._keys = np.zeros((1, 1), np.uint64)
        self._material: Material | None = None

    @property
    def material(self) -> Material | None:
        """A constant bottom as a material, if it has a table."""
        return self._material

    def update(self, grid: TexelGrid | None) -> None:
        """Encode the bottom where it has changed since the last call with the same grid.

        Raises:
            ParameterError: a value of the bottom is negative or not finite.
        """
        nested = nested_latents(self._bottom, self._model)
        own = isinstance(self._model.networks, UrushiNetworks)
        surface = known_surface(self._bottom) if own else None
        if surface is not None and surface.bare and surface.widths > self._model.widths:
            surface = None  # averaged over the azimuth
        self._material = None
        if nested is not None and nested.resolution is None:
            self._keep_same(nested.at(np.full((1, 2), 0.5)))
            self._keep_table(self._bottom.latents.material)
        elif grid is None or (nested is None and not varying_textures(self._bottom)):
            self._keep_same(self._encoded()[None])
        elif nested is not None:
            self._update_texels(grid, _NestedBottom(nested))
        elif surface is None:
            probed = _ProbedBottom(self._model, self._bottom, self._where, grid)
            self._update_texels(grid, probed)
        elif surface.bare:
            self._codes = _BareBottom(self._model, surface, self._where, grid)
            self._grid = None
        else:
            self._update_texels(grid, _DiffuseBottom(self._model, surface, self._where))

    def read(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Keys (n or 1, C) and codes (n or 1, C, size) of a range of texels."""
        if isinstance(self._codes, np.ndarray):
            return self._keys, self._codes
        if isinstance(self._codes, _BareBottom):
            return self._codes.read(start, stop)
        return self._keys[start:stop], self._codes.read(slice(start, stop))

    def _encoded(self) -> np.ndarray:
        """Codes (C, size) of a constant bottom."""
        check_bottom(self._bottom, self._where)
        source = reflection_source(self._bottom)
        tables = isinstance(self._model.networks, UrushiNetworks) and self._model.widths == 1
        material, deviations = encode_source(
            source,
            self._model,
            table=tables and source.measured,
            name=f"{self._where}: the nested BSDF",
        )
        for sentence in deviations.warnings():
            mi.Log(mi.LogLevel.Warn, f"{self._where}: {sentence}")
        exact = getattr(self._bottom, "tabulated", None) if tables else None
        if exact is not None:
            f = probing.check_values(reflection_source(exact).f(*node_pairs()), self._where)
            table = table_of_values(f)
            material = Material(material.latents, self._model, material.anchors, table)
        self._keep_table(material)
        return material.anchors

    def _keep_table(self, material: Material) -> None:
        self._material = None if material.table is None else material

    def _keep_same(self, codes: np.ndarray) -> None:
        """One code a channel, (1, C, size)."""
        self._codes, self._grid = codes, None
        self._keys = texel_hash.row_hashes(list(np.moveaxis(codes, -1, 0)))

    def _update_texels(
        self, grid: TexelGrid, source: "_NestedBottom | _ProbedBottom | _DiffuseBottom"
    ) -> None:
        channels = spectrum.channel_count()
        if self._grid != grid:
            self._grid = grid
            layout = packing.texel_layout(self._model, channels)
            self._codes = TextureStore(self._model, layout, grid.width, grid.height)
            self._keys = np.zeros((grid.texels, channels), np.uint64)
        assert isinstance(self._codes, TextureStore)
        if self._codes.empty:
            self._keys[:] = 0  # an error ended the last attempt
        with self._codes.writing() as write:
            for start in range(0, grid.texels, TEXEL_BLOCK):
                stop = min(start + TEXEL_BLOCK, grid.texels)
                uv = grid.uv(start, stop)
                present = source.keys(uv)
                rows = np.flatnonzero((present != self._keys[start:stop]).any(axis=1))
                if len(rows):
                    write(start + rows, *source.codes(uv[rows], present[rows]))
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

    def codes(self, uv: np.ndarray, present: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Codes (k, size), and which of them (M, C) points uv (M, 2) with keys (M, C) have."""
        codes = self._latents.at(uv)
        return codes.reshape(-1, codes.shape[-1]), np.arange(present.size).reshape(present.shape)


class _BareBottom:
    """Codes of a bottom that is a lobe and nothing else, made of its textures when they are read.

    Nothing is stored: they cost less than a look-up.
    """

    def __init__(self, model: Model, surface: KnownSurface, where: str, grid: TexelGrid):
        self._model, self._surface, self._where, self._grid = model, surface, where, grid

    def read(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Keys (n, C) and codes (n, C, size) of a range of texels."""
        lobe = probing.check_values(self._surface.at(self._grid.uv(start, stop)).lobe, self._where)
        if self._model.widths == 2 and self._surface.widths == 1:
            lobe = with_two_widths(lobe)
        for reach in (lobe[..., :4], lobe[..., 6:]):  # all but the index
            np.minimum(reach, 1, out=reach)
        keys = texel_hash.row_hashes(list(np.moveaxis(lobe, -1, 0)))
        return keys, bare_anchors(self._model, lobe)


class _DiffuseBottom:
    """Codes of a Lambertian bottom."""

    def __init__(self, model: Model, surface: KnownSurface, where: str):
        self._model, self._surface, self._where = model, surface, where

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2): equal where the reflectance is."""
        return texel_hash.row_hashes([self._surface.at(uv).diffuse])

    def codes(self, uv: np.ndarray, present: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Codes (k, size), and which of them (M, C) points uv (M, 2) with keys (M, C) have."""
        reflectance = probing.check_values(self._surface.at(uv).diffuse, self._where)
        row, row_of = texel_hash.unique_rows(present.ravel())
        pairs = len(self._model.networks.pairs()[0])
        f = np.repeat(reflectance.reshape(-1, 1)[row] / np.float32(np.pi), pairs, axis=1)
        codes = encoder_codes(self._model, f, np.array(no_lobe(self._model.widths), np.float32))
        return limit_albedo(self._model, codes), row_of.reshape(present.shape)


class _ProbedBottom:
    """Codes of a bottom that is evaluated at the probe pairs."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str, grid: TexelGrid):
        self._model, self._bottom, self._where = model, bottom, where
        self._has_lobes = isinstance(model.networks, UrushiNetworks)
        self._pairs = model.networks.pairs()
        self._average = probing.needed_averaging(bottom, *self._pairs, grid, where, model.widths)

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

    def codes(self, uv: np.ndarray, present: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Codes (k, size), and which of them (M, C) points uv (M, 2) with keys (M, C) have."""
        channels = present.shape[1]
        texel, texel_of = texel_hash.unique_rows(texel_hash.row_hashes(list(present.T)))
        row, row_of = texel_hash.unique_rows(present[texel].ravel())
        parts = []
        for start in range(0, len(texel), PROBED_TEXELS):
            points = uv[texel[start : start + PROBED_TEXELS]]
            count, first = len(points) * channels, start * channels
            own = row[slice(*np.searchsorted(row, [first, first + count]))] - first
            lobes = self._lobes(points)
            if lobes is not None:
                lobes = lobes.reshape(count, -1)[own]
                if getattr(self._bottom, "bare", False):
                    parts.append(bare_anchors(self._model, lobes))
                    continue
            f = probing.texel_values(self._bottom, *self._pairs, points, self._average)
            f = probing.check_values(f, self._where).reshape(count, -1)[own]
            anchors = without_useless_rests(self._model, encoder_codes(self._model, f, lobes), f)
            parts.append(limit_mean_albedo(self._model, anchors))
        codes = np.concatenate(parts)
        return codes, row_of.reshape(len(texel), channels)[texel_of]

    def _lobes(self, points: np.ndarray) -> np.ndarray | None:
        """Lobes (M, C, N) at points uv (M, 2) as the networks take them; None: they are fitted."""
        lobes = probing.known_lobes(self._bottom, points) if self._has_lobes else None
        if lobes is None:
            return None
        lobes = probing.check_values(lobes, self._where)
        if lobes.shape[-1] < self._model.arch.lobe:
            lobes = with_two_widths(lobes)
        # Networks of one width fit a lobe of two.
        return lobes if lobes.shape[-1] == self._model.arch.lobe else None
