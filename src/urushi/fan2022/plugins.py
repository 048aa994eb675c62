"""The Mitsuba plugins `fan2022_brdf` and `fan2022_layered`.

Render them within `kernels.separate_kernels`. Outside `mi.render`, they enter it themselves.
"""

import contextlib
import warnings
from functools import partial
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError, PlatformError, UrushiWarning
from urushi.fan2022.architecture import LATENT
from urushi.fan2022.kernels import PaperDecoder, PaperSampler, separate_kernels
from urushi.fan2022.material import Material, encode, load
from urushi.fan2022.networks import PaperNetworks, projection_pairs
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.bottoms import KEY_BITS
from urushi.mitsuba.latents.lookup import are_constant, drawn_texel, texel_draw
from urushi.mitsuba.plugins.base import resolve
from urushi.mitsuba.reading import grid as grids
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import (
    COAT_PROPERTIES,
    CoatTextures,
    check_bottom,
    nested_bsdf,
)
from urushi.mitsuba.recording import only_where, owned
from urushi.mitsuba.register import Room
from urushi.textures.bake import code_hashes
from urushi.textures.mip_pyramid import half_resolution
from urushi.textures.store import MIDDLE, TexelGrid

#: Texels whose bottom is evaluated at once: bounds memory.
TEXELS = 1 << 10

RECORDED = (
    "networks of Fan et al. 2022 are recorded in one kernel with the whole path, which takes "
    "minutes to compile; render within `urushi.fan2022.separate_kernels()`"
)


class TexelCodes:
    """Codes on a grid of texels, in single precision, in Dr.Jit.

    Mip levels are means of codes: the networks' latent space is linear (Fan et al. 2022).
    """

    DRJIT_STRUCT: ClassVar = {"_numbers": object, "_levels": list}  # for frozen functions

    def __init__(
        self,
        networks: PaperNetworks,
        codes: np.ndarray,
        grid: TexelGrid = MIDDLE,
        mipmaps: bool = False,
    ):
        """codes: (T, C, 32) of the grid's texels, or (1, C, 32)."""
        self.codes = np.broadcast_to(codes, (grid.texels, *codes.shape[1:]))
        levels = [self.codes.reshape(grid.height, grid.width, *codes.shape[1:])]
        while mipmaps and levels[-1].shape[:2] != (1, 1):
            levels.append(half_resolution(levels[-1], 0, len(levels[-1])))
        numbers = np.concatenate([level.reshape(-1, *codes.shape[1:]) for level in levels])
        self.grid, self._numbers = grid, owned(mi.Float, numbers)
        # Of each level the number of texels before it, and its width and height.
        sizes = np.array(
            [(h * w, w, h) for h, w, *_ in (level.shape for level in levels)], np.uint32
        )
        sizes[:, 0] = np.cumsum(sizes[:, 0]) - sizes[:, 0]
        self._levels = [owned(mi.UInt32, column) for column in sizes.T]
        self._decoder, self._sampler = PaperDecoder(networks.params), PaperSampler(networks.params)

    def vertex(self, si) -> list[list]:
        """The codes at a surface interaction: a list (32) of Dr.Jit floats for each channel.

        One texel is drawn, as in `mitsuba.latents.lookup`, of a level whose texels have the size of
        a pixel where the integrator computes derivatives of uv.
        """
        (a, b, c), (d, e, f) = self.grid.to_texture
        point = a * si.uv.x + b * si.uv.y + c, d * si.uv.x + e * si.uv.y + f
        draw, count = texel_draw(si.uv, si.wi), dr.width(self._levels[0])
        offset, width, height = (
            mi.UInt32(0),
            mi.UInt32(self.grid.width),
            mi.UInt32(self.grid.height),
        )
        if count > 1 and not are_constant(si.duv_dx, si.duv_dy):
            squared = mi.Float(1)
            for change in (si.duv_dx, si.duv_dy):
                x, y = a * change.x + b * change.y, d * change.x + e * change.y
                squared = dr.maximum(squared, dr.square(x * width) + dr.square(y * height))
            level = dr.minimum(mi.UInt32(0.5 * dr.log2(squared) + draw[2]), count - 1)
            offset, width, height = (dr.gather(mi.UInt32, x, level) for x in self._levels)
        sizes, channels = (mi.Int32(width), mi.Int32(height)), self.channels
        first = (offset + drawn_texel(point, sizes, self.grid, draw)) * channels
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

    def proposal(self, vertex: list[list]) -> Any:
        return self._sampler.proposal([sum(z) / self.channels for z in zip(*vertex, strict=True)])

    @property
    def channels(self) -> int:
        """Number of codes of a texel, one per channel."""
        return self.codes.shape[1]


def define(base: type) -> dict[str, type]:
    """Make the plugins' classes in the current variant; base: of `define_proposal_bsdf`."""

    class PaperBSDF(base):
        """A BRDF by codes of the paper's networks; subclasses set `codes`."""

        codes: TexelCodes

        #: Commands render scenes with such a BSDF within `separate_kernels`.
        separate_kernels = True

        def _load(self, props):
            if dr.backend_v(mi.Float) == dr.JitBackend.CUDA:
                raise PlatformError(
                    f"{self._where} works on CPUs alone, because GPUs have its kernels in half "
                    "precision; choose the variant llvm_ad_rgb"
                )
            if "weights" not in props:
                raise ParameterError(f"{self._where} has no weights; give a file of its networks")
            self.networks = PaperNetworks.read(resolve(props["weights"]))

        def _vertex(self, si, active):
            return self.codes.vertex(si)

        def _f(self, vertex, ctx, si, wo, active):
            return self.codes.f(vertex, si, wo, active)

        def _proposal(self, vertex, si, active):
            return self.codes.proposal(vertex)

    class PaperBRDF(PaperBSDF):
        """A saved material of the system of Fan et al. 2022 (``fan2022_brdf``).

        ============== ===================== ====================================================
        filename       string                File of ``urushi.fan2022.Material.save``. (Required)
        weights        string                File of the networks. (Required)
        ============== ===================== ====================================================
        """

        PROPERTIES = ("filename", "weights")

        def _load(self, props):
            super()._load(props)
            if "filename" not in props:
                raise ParameterError(f"{self._where} has no filename; give a file of Material.save")
            material = load(resolve(props["filename"]), self.networks)
            self.codes = TexelCodes(self.networks, material.latents[None])
            self._file = props["filename"]

        def to_string(self):
            return f"PaperBRDF[filename = {self._file}]"

    class PaperLayered(PaperBSDF):
        """A coat over any BSDF by the system of Fan et al. 2022 (``fan2022_layered``).

        ============== ===================== ====================================================
        weights        string                File of the networks. (Required)
        resolution     integer               Texels per side if anything is textured. (Default: that
                                             of the largest texture; 384 bytes for an RGB texel)
        mipmaps        boolean               Whether to average codes to mip levels, as for
                                             ``neural_layered``. (Default: false)
        ============== ===================== ====================================================

        The coat and the nested BSDF are given as for ``neural_layered``, isotropic and with indices
        above one. Every different bottom, and every pair of ``alpha`` and index, is projected,
        which takes seconds or minutes; a texture has at most 256 of these pairs. Codes are kept in
        memory.
        """

        PROPERTIES = COAT_PROPERTIES

        def _load(self, props):
            self._bottom = nested_bsdf(props)
            super()._load(props)
            self._mipmaps = bool(props.get("mipmaps", False))
            self._coat = CoatTextures(props)
            check_bottom(self._bottom, self._coat.where)
            if self._coat.is_anisotropic or self._coat.has_rotation:
                raise ParameterError(
                    f"{self._coat.where}: the networks are for isotropic lobes; give alpha instead "
                    "of alpha_u and alpha_v, and no rotation"
                )
            self._resolution = int(props.get("resolution", 0))
            self._update([])

        def _update(self, keys):
            self._coat.parameters_changed()
            grids.check_normals(self._bottom, self._coat.where)
            below = isinstance(self._bottom, PaperBSDF) and self._bottom.codes
            inner = below.grid if below and below.grid != MIDDLE else None
            parts = self._coat.textures | ({} if below else {"the nested BSDF": self._bottom})
            chosen = grids.choose(parts, inner, self._resolution, self._coat.where) or MIDDLE
            coat = self._coat.layering(chosen.uv())
            codes = self.networks.layer(self._bottom_codes(below, chosen), coat)
            self.codes = TexelCodes(self.networks, codes, chosen, self._mipmaps)

        def _bottom_codes(self, below, grid):
            """Codes (T or 1, C, 32) of the bottom on a grid; below: its own codes, or False."""
            if below and self._bottom.networks.fingerprint == self.networks.fingerprint:
                return below.codes if below.grid == MIDDLE else _read(below, grid)
            if grid == MIDDLE or not grids.varying_textures(self._bottom):
                return encode(self._bottom, self.networks).latents[None]
            pairs = projection_pairs()
            average = probing.needed_averaging(self._bottom, *pairs, grid, self._coat.where)
            values = partial(probing.texel_values, self._bottom, *pairs, average=average)
            parts = []
            for start in range(0, grid.texels, TEXELS):
                uv = grid.uv(start, min(start + TEXELS, grid.texels))
                f = probing.check_values(values(uv), self._coat.where)
                keys = code_hashes(f, KEY_BITS).ravel()
                _, first, label = np.unique(keys, return_index=True, return_inverse=True)
                codes = self.networks.encode(f.reshape(-1, f.shape[-1])[first])
                parts.append(codes[label].reshape(*f.shape[:2], LATENT))
            return np.concatenate(parts)

        def save(self, path):
            """Write the codes of a constant coat to a file that ``fan2022_brdf`` loads.

            Raises:
                ParameterError: the codes are a texture.
                FileError: the file cannot be written.
            """
            if self.codes.grid != MIDDLE:
                raise ParameterError(f"{self._where}: textures of its codes cannot be saved")
            Material(self.codes.codes[0], self.networks).save(path)

        def traverse(self, callback):
            self._coat.traverse(callback, mi.ParamFlags.NonDifferentiable)
            callback.put("bottom", self._bottom, mi.ParamFlags.NonDifferentiable)

        def to_string(self):
            bottom = str(self._bottom).replace("\n", "\n  ")
            return f"PaperLayered[\n{self._coat},\n  bottom = {bottom}\n]"

    return {"fan2022_brdf": PaperBRDF, "fan2022_layered": PaperLayered}


def _read(below: TexelCodes, grid: TexelGrid) -> np.ndarray:
    """Codes (T, C, 32) of a textured bottom at the texels of a grid."""
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (grid.texels, 1)), grid.uv())
    return np.array([[z.numpy() for z in codes] for codes in below.vertex(si)]).transpose(2, 0, 1)


ROOM = Room(define, ("fan2022_brdf", "fan2022_layered"))
