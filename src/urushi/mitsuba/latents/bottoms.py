"""Latent codes of the bottom of a coat, a Mitsuba BSDF that is constant or textured.

A textured bottom that is known by its values is compared by a few probes of each texel and channel.
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.core.table import node_pairs, table_of_values
from urushi.material.energy import limit_albedo
from urushi.material.material import Material
from urushi.material.values import codes_of, encode_source
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.bsdf import reflection_source
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.reading.offers import Latents, offer_of
from urushi.mitsuba.reading.parameters import check_bottom
from urushi.nets.lobe import f as lobe_f
from urushi.nets.lobe import no_lobe, with_two_widths
from urushi.nets.weights import Model
from urushi.textures.bake import BakedTexture, RowsAt, Source, code_hashes, row_hashes
from urushi.textures.store import MIDDLE, TexelGrid

#: Texels that are probed at once: bounds memory.
PROBED_TEXELS = 1 << 13

#: Stride of the probe pairs by which texels are compared, and bits of the mantissa to which their
#: values are rounded: texels that differ by less than 0.2 % share a code.
KEY_STRIDE, KEY_BITS = 24, 9

#: Reflectance of a black surface in logarithms.
BLACK = 1e-9

#: Width below which a lobe stays beside the table of a bottom, which is too coarse for it.
NARROW = 0.0225


class BottomCodes:
    """The codes of a bottom: `open` prepares them, `bake` computes those that are stored."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str):
        self._model, self._bottom, self._where = model, bottom, where
        self._baked: BakedTexture | None = None
        self._opened: Source | None = None
        self.material: Material | None = None  # of a constant bottom; None: it varies over uv
        self.stored = self._stale = False  # whether codes of texels are stored; have to be computed

    def open(self, grid: TexelGrid | None) -> None:
        """Read the bottom, after each of its changes. If it is constant, it is encoded."""
        offer = offer_of(self._bottom)
        nested = nested_latents(self._bottom, self._model)
        self.material, self.stored, self._stale = None, False, True
        if nested is not None and nested.grid is None:
            codes = nested.at(np.full((1, 2), 0.5))[0]
            self._opened = _uniform(
                codes[list(spectrum.FINE_AT_RGB)] if is_finer(nested) else codes
            )
            assert offer.latents is not None  # for the type checker
            self.material = offer.latents.material
        elif grid is None or (nested is None and not varying_textures(self._bottom)):
            self._opened = _uniform(self._encoded())
        elif nested is not None:
            self._opened = _nested(nested, grid)
        elif offer.bare and _lobes(self._model, self._bottom, MIDDLE.uv(), self._where) is not None:
            self._opened = _bare(self._model, self._bottom, self._where, grid)
        else:
            self.stored = True
            if offer.reflectance is None:
                probed = _ProbedBottom(self._model, self._bottom, self._where, grid)
                self._opened = probed.read
            else:
                self._opened = _diffuse(self._model, offer.reflectance, self._where, grid)
            if self._baked is None or self._baked.grid != grid:
                self._baked = BakedTexture(self._model, grid, spectrum.channel_count())
            return
        self._baked = None

    def bake(self, advance: Callable[[int], Any] = lambda texels: None) -> None:
        """Compute the codes that are stored, where texels have changed before the last `open`.

        advance: as of `BakedTexture.update`.
        """
        if self._stale and self._baked is not None and self._opened is not None:
            self._baked.update(self._opened, advance)
        self._stale = False

    def source(self, start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        """The bottom as a `Source`, after `bake`."""
        source = self._opened if self._baked is None else self._baked.read
        assert source is not None  # for the type checker
        return source(start, stop)

    def read(self, start: int, stop: int) -> np.ndarray:
        """Codes (n, C, size) of a range of texels."""
        shape = stop - start, spectrum.channel_count()
        rows = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
        return self.source(start, stop)[1](*rows).reshape(*shape, -1)

    def _encoded(self) -> np.ndarray:
        """Codes (C, size) of a constant bottom."""
        check_bottom(self._bottom, self._where)
        source = reflection_source(self._bottom)
        tables = self._model.widths == 1
        name = f"{self._where}: the nested BSDF"
        material, deviations = encode_source(source, self._model, name=name)
        for sentence in deviations.warnings():
            mi.Log(mi.LogLevel.Warn, f"{self._where}: {sentence}")
        exact = offer_of(self._bottom).exact() if tables else None
        if exact is not None:
            wi, wo = node_pairs()
            f = probing.check_values(reflection_source(exact).f(wi, wo), self._where)
            lobe = material.latents[:, : self._model.arch.lobe]
            narrow = source.lobe is not None and bool((lobe[:, 0] < NARROW).any())
            if narrow:
                f = np.maximum(f - lobe_f(lobe, wi[:, None], wo[:, None]), 0)
            material = replace(material, table=table_of_values(f), beside_lobe=narrow)
        self.material = material
        return material.latents


def _uniform(codes: np.ndarray) -> Source:
    """The source of a bottom that has the same codes (C, size) everywhere."""
    hashes = code_hashes(codes[None])
    return lambda start, stop: (hashes, lambda texel, channel: codes[channel])


def nested_latents(bottom: "mi.BSDF", model: Model) -> Latents | None:
    """The codes below a coat of a bottom that has codes of the same weights, or None."""
    nested = offer_of(bottom).latents
    if nested is None or nested.model.fingerprint != model.fingerprint:
        return None
    same = nested.channels == spectrum.channel_count()
    return nested if same or is_finer(nested) else None


def is_finer(latents: Latents) -> bool:
    """Whether codes have the bands `spectrum.FINE`, but materials are read at three bands."""
    return latents.channels == spectrum.COUNT > spectrum.channel_count()


def _nested(latents: Latents, grid: TexelGrid) -> Source:
    """The source of a bottom that consists of codes itself."""

    def read(start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        codes = latents.at(grid.uv(start, stop))
        return code_hashes(codes), lambda texel, channel: codes[texel, channel]

    return read


def _lobes(model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str) -> np.ndarray | None:
    """Lobes (M, C, N) at points uv (M, 2) as codes have them; None: they are fitted."""
    lobes = probing.known_lobes(bottom, uv)
    if lobes is None:
        return None
    lobes = probing.check_values(lobes, where)
    if lobes.shape[-1] < model.arch.lobe:
        lobes = with_two_widths(lobes)
    # Codes of one width fit a lobe of two.
    return lobes if lobes.shape[-1] == model.arch.lobe else None


def _bare(model: Model, bottom: "mi.BSDF", where: str, grid: TexelGrid) -> Source:
    """The source of a bottom that is a lobe and nothing else."""

    def read(start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        lobe = _lobes(model, bottom, grid.uv(start, stop), where)
        assert lobe is not None  # for the type checker
        for reach in (lobe[..., :4], lobe[..., 6:]):  # all but the index
            np.minimum(reach, 1, out=reach)
        rest = model.networks.empty_rest()

        def codes_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            own = lobe[texel, channel]
            return np.concatenate([own, np.broadcast_to(rest, (len(own), len(rest)))], axis=1)

        return code_hashes(lobe), codes_at

    return read


@functools.lru_cache(maxsize=8)
def white_code(model: Model) -> np.ndarray:
    """The code (size,) of a Lambertian surface that reflects all light."""
    white = np.full(len(model.networks.pairs()[0]), 1 / np.pi, np.float32)
    return codes_of(model, white, np.array(no_lobe(model.widths), np.float32))


def _diffuse(
    model: Model, reflectance_at: Callable[[Any], list], where: str, grid: TexelGrid
) -> Source:
    """The source of a Lambertian bottom."""

    def read(start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        uv = grid.uv(start, stop)
        si = spectrum.points(uv)
        channels = spectrum.at_bands(si, lambda: reflectance_at(si))
        reflectance = spectrum.stacked([[x] for x in channels], len(uv))[..., 0]
        probing.check_values(reflectance, where)

        def codes_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            codes = np.tile(white_code(model), (len(texel), 1))
            factors = np.maximum(reflectance[texel, channel], BLACK)
            return limit_albedo(model, model.networks.rest_scaled(codes, factors))

        return row_hashes([reflectance]), codes_at

    return read


class _ProbedBottom:
    """Codes of a bottom that is evaluated at the probe pairs, a `Source`."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str, grid: TexelGrid):
        self._model, self._bottom, self._where, self._grid = model, bottom, where, grid
        self._pairs = model.networks.pairs()
        self._average = probing.needed_averaging(bottom, *self._pairs, grid, where, model.widths)

    def read(self, start: int, stop: int) -> tuple[np.ndarray, RowsAt]:
        uv = self._grid.uv(start, stop)
        return self._hashes(uv), lambda texel, channel: self._codes(uv, texel, channel)

    def _hashes(self, uv: np.ndarray) -> np.ndarray:
        """Hashes (M, C) at points uv (M, 2): equal where the bottom is, within `KEY_BITS`."""
        wi, wo = (w[::KEY_STRIDE] for w in self._pairs)
        if self._average.repeats > 1:  # values of a random BSDF cannot be compared
            shape = len(uv), spectrum.channel_count()
            return np.random.default_rng().integers(1 << 63, size=shape).astype(np.uint64)
        f = probing.texel_values(self._bottom, wi, wo, uv, probing.Averaging())
        return code_hashes(f, KEY_BITS)

    def _codes(self, uv: np.ndarray, texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
        """Codes (k, size) of rows: texels (k,), which ascend, at points uv (M, 2), and channels."""
        texels, place = np.unique(texel, return_inverse=True)
        parts = []
        for start in range(0, len(texels), PROBED_TEXELS):
            rows = slice(*np.searchsorted(place, [start, start + PROBED_TEXELS]))
            own = place[rows] - start, channel[rows]
            points = uv[texels[start : start + PROBED_TEXELS]]
            lobes = _lobes(self._model, self._bottom, points, self._where)
            f = probing.texel_values(self._bottom, *self._pairs, points, self._average)
            f = probing.check_values(f, self._where)[own]
            own_lobes = None if lobes is None else lobes[own][:, None]
            # Each row is a material of its own.
            parts.append(codes_of(self._model, f[:, None], own_lobes)[:, 0])
        return np.concatenate(parts)
