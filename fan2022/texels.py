"""Textures of codes of the networks of Fan et al. 2022, in Dr.Jit.

One texel is drawn, as in `mitsuba.latents.over_axes`. Mip levels are means of codes: the networks'
latent space is linear (Fan et al. 2022).
"""

import contextlib
import warnings
from collections.abc import Mapping

import drjit as dr
import mitsuba as mi
import numpy as np

from fan2022.architecture import LATENT
from fan2022.inference import GaussianMixture
from fan2022.kernels import PaperDecoder, PaperSampler, separate_kernels
from fan2022.networks import PaperNetworks
from urushi.errors import ParameterError, UrushiWarning
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.over_axes import drawn_texel
from urushi.mitsuba.reading.grid import not_over_uv, varying_textures
from urushi.mitsuba.recording import only_where, owned
from urushi.textures.store import ONE_TEXEL, TexelGrid

RECORDED = (
    "networks of Fan et al. 2022 are recorded in one kernel with the whole path, which takes "
    "minutes to compile; render by `python -m fan2022 render`, "
    "or within `fan2022.separate_kernels()`"
)

#: Texels per side for procedural textures, and the largest side that is chosen automatically.
PROCEDURAL, LARGEST = 256, 2048

#: Steps of f from one number to e times it: values within a step are the same bottom.
STEPS = 512

#: [1/sr] Values of f below it count as it.
LEAST_F = 1e-12


def choose(
    parts: Mapping[str, "mi.Object"], inner: TexelGrid, resolution: int, where: str
) -> TexelGrid:
    """The grid over the unit square of uv that resolves all textures; `ONE_TEXEL` without any.

    Args:
        parts: the objects that hold the textures, by the names that errors use.
        inner: the grid of the bottom's codes.
        resolution: texels per side; 0 to choose it from the textures.
        where: start of errors.
    """
    sizes = [np.array(inner[:2])]
    for name, part in parts.items():
        if dependence := not_over_uv(part):
            raise ParameterError(
                f"{where}: {name} depends on {dependence}, but coats are baked over uv; "
                "give a texture over uv, or use the plugin 'layered', which evaluates every point"
            )
        sizes += map(_resolution, varying_textures(part))
    width, height = np.minimum(np.max(sizes, axis=0), LARGEST).tolist()
    if width * height == 1:
        return ONE_TEXEL
    return TexelGrid(resolution or width, resolution or height)


def _resolution(texture: "mi.Texture") -> np.ndarray:
    """Texels of one texture along u and v, with its repetitions over the unit square of uv."""
    size, parameters = np.array(texture.resolution()), mi.traverse(texture)
    if size.prod() <= 1:
        return np.array([PROCEDURAL, PROCEDURAL])
    matrix = np.asarray(parameters["to_uv"].matrix.numpy()).reshape(3, 3)
    return np.maximum(np.round(size * np.abs(matrix[:2, :2]).max(axis=1)), 1).astype(int)


class CodeTexture:
    """Codes on a grid of texels, in single precision, and f and proposals of its vertices."""

    def __init__(
        self,
        networks: PaperNetworks,
        codes: np.ndarray,
        grid: TexelGrid = ONE_TEXEL,
        mipmaps: bool = False,
    ):
        """codes: (T, C, 32) of the grid's texels, or (1, C, 32)."""
        self.codes = np.broadcast_to(codes, (grid.texels, *codes.shape[1:]))
        levels = [self.codes.reshape(grid.height, grid.width, *codes.shape[1:])]
        while mipmaps and levels[-1].shape[:2] != (1, 1):
            levels.append(half_resolution(levels[-1]))
        self.grid = grid
        self._grids = [grid._replace(width=x.shape[1], height=x.shape[0]) for x in levels]
        self._numbers = owned(mi.Float, np.concatenate([x.ravel() for x in levels]))
        self._decoder, self._sampler = PaperDecoder(networks.params), PaperSampler(networks.params)

    def vertex(self, si) -> list[list]:
        """The codes at a surface interaction: a list (32) of Dr.Jit floats for each channel.

        They are of a level whose texels have about the size of a pixel where the integrator
        computes derivatives of uv.
        """
        texel, before, channels = mi.UInt32(0), 0, self._channels
        level = self._level(si)
        for k, grid in enumerate(self._grids):
            column, row = drawn_texel(si, grid)
            own = before + mi.UInt32(row * mi.Int32(grid.width) + column)
            texel, before = dr.select(level == k, own, texel), before + grid.texels
        return [
            [
                dr.gather(mi.Float, self._numbers, (texel * channels + c) * LATENT + i)
                for i in range(LATENT)
            ]
            for c in range(channels)
        ]

    def _level(self, si) -> "mi.UInt32":
        """The mip level at a surface interaction."""
        squared = mi.Float(1)
        for change in (si.duv_dx, si.duv_dy):
            length = dr.square(change.x * self.grid.width) + dr.square(change.y * self.grid.height)
            squared = dr.maximum(squared, length)
        last = len(self._grids) - 1
        return dr.minimum(mi.UInt32(0.5 * dr.log2(squared) + 0.5), last) if last else mi.UInt32(0)

    def f(self, vertex: list[list], si, wo, active) -> "mi.Spectrum":
        recorded = dr.flag(dr.JitFlag.SymbolicScope)
        if recorded:
            warnings.warn(RECORDED, UrushiWarning, stacklevel=2)
        with contextlib.nullcontext() if recorded else separate_kernels():
            channels = only_where(active, self._decoder.f, vertex, si.wi, wo)
        return spectrum.from_channels(channels, si.wavelengths, colors=True)

    def proposal(self, vertex: list[list]) -> GaussianMixture:
        return self._sampler.proposal([sum(z) / self._channels for z in zip(*vertex, strict=True)])

    @property
    def _channels(self) -> int:
        return self.codes.shape[1]


def half_resolution(values: np.ndarray) -> np.ndarray:
    """Averages (h, w, ...) over areas of a level's values (H, W, ...): the next level."""
    return _half(_half(values).swapaxes(0, 1)).swapaxes(0, 1)


def _half(values: np.ndarray) -> np.ndarray:
    """Averages along the first axis: of two values, or of three by area if the count is odd."""
    count, half = len(values), max(len(values) // 2, 1)
    edges = np.linspace(0, count, half + 1)[:, None]
    before = np.clip(edges - np.arange(count), 0, 1)  # shares of values before an edge
    share = np.diff(before, axis=0) * (half / count)
    return np.tensordot(share.astype(np.float32), values, 1)


def different_rows(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices (K,) of rows of f (M, P) that differ, and the place (M,) of each row among them."""
    steps = np.rint(STEPS * np.log(np.maximum(f, LEAST_F))).astype(np.int32)
    _, first, place = np.unique(steps, axis=0, return_index=True, return_inverse=True)
    return first, place.ravel()
