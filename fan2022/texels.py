"""Textures of codes of the networks of Fan et al. 2022, in Dr.Jit.

One texel is drawn, as in `mitsuba.reading.textures`.
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
from urushi.mitsuba.latents.texels import drawn_texel
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

    def __init__(self, networks: PaperNetworks, codes: np.ndarray, grid: TexelGrid = ONE_TEXEL):
        """codes: (T, C, 32) of the grid's texels, or (1, C, 32)."""
        self.grid = grid
        self.codes = np.broadcast_to(codes, (grid.texels, *codes.shape[1:]))
        self._numbers = owned(mi.Float, self.codes)
        self._decoder, self._sampler = PaperDecoder(networks.params), PaperSampler(networks.params)

    def vertex(self, si) -> list[list]:
        """The codes at a surface interaction: a list (32) of Dr.Jit floats for each channel."""
        channels, (column, row) = self._channels, drawn_texel(si, self.grid)
        first = mi.UInt32(row * mi.Int32(self.grid.width) + column) * channels
        return [
            [dr.gather(mi.Float, self._numbers, (first + c) * LATENT + i) for i in range(LATENT)]
            for c in range(channels)
        ]

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


def different_rows(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices (K,) of rows of f (M, P) that differ, and the place (M,) of each row among them."""
    steps = np.rint(STEPS * np.log(np.maximum(f, LEAST_F))).astype(np.int32)
    _, first, place = np.unique(steps, axis=0, return_index=True, return_inverse=True)
    return first, place.ravel()
