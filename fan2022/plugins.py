"""The Mitsuba plugins `fan2022_brdf` and `fan2022_layered`.

Render them within `kernels.separate_kernels`. Outside `mi.render`, they enter it themselves.
"""

from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from fan2022.architecture import LATENT
from fan2022.material import Material, encode, load
from fan2022.networks import PaperNetworks, projection_pairs
from fan2022.texels import CodeTexture, choose, different_rows
from urushi.errors import ParameterError, PlatformError
from urushi.mitsuba.properties import path_of, switch_of
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import check_nodes, varying_textures
from urushi.mitsuba.reading.nested import check_bottom, nested_bsdf
from urushi.mitsuba.reading.parameters import COAT_PROPERTIES, CoatTextures
from urushi.mitsuba.reading.ranges import check_coat
from urushi.mitsuba.register import PluginSet
from urushi.mitsuba.surface import Surface, surface_of
from urushi.textures.store import ONE_TEXEL, TexelGrid

#: Texels whose bottom is evaluated at once: bounds memory.
TEXELS = 1 << 10


class PaperSurface(Surface):
    """A BRDF by codes of the paper's networks; subclasses set `codes`."""

    codes: CodeTexture

    def _load(self, props):
        if dr.backend_v(mi.Float) == dr.JitBackend.CUDA:
            raise PlatformError(
                f"{self._where} works on CPUs alone, because GPUs have its kernels in half "
                "precision; choose the variant llvm_ad_rgb"
            )
        if "weights" not in props:
            raise ParameterError(f"{self._where} has no weights; give a file of its networks")
        self.networks = PaperNetworks.read(path_of(props, "weights"))

    def _vertex(self, si, active):
        return self.codes.vertex(si)

    def _f(self, vertex, ctx, si, wo, active):
        return self.codes.f(vertex, si, wo, active)

    def _proposal(self, vertex, si, active):
        return self.codes.proposal(vertex)


class PaperBRDF(PaperSurface):
    """A saved material of the system of Fan et al. 2022 (``fan2022_brdf``).

    ============== ===================== ====================================================
    filename       string                File of ``fan2022.Material.save``. (Required)
    weights        string                File of the networks. (Required)
    ============== ===================== ====================================================
    """

    PROPERTIES = ("filename", "weights")

    def _load(self, props):
        super()._load(props)
        if "filename" not in props:
            raise ParameterError(f"{self._where} has no filename; give a file of Material.save")
        material = load(path_of(props, "filename"), self.networks)
        self.codes = CodeTexture(self.networks, material.latents[None])
        self._file = props["filename"]

    def to_string(self):
        return f"PaperBRDF[filename = {self._file}]"


class PaperLayered(PaperSurface):
    """A coat over any BSDF by the system of Fan et al. 2022 (``fan2022_layered``).

    ============== ===================== ====================================================
    weights        string                File of the networks. (Required)
    resolution     integer               Texels per side if anything is textured. (Default: that
                                         of the largest texture; 384 bytes for an RGB texel)
    mipmaps        boolean               Whether to average codes to mip levels, for
                                         integrators that compute derivatives of uv. Those that
                                         ship with Mitsuba do not. (Default: false)
    ============== ===================== ====================================================

    The coat and the nested BSDF are given as for ``neural_layered``, isotropic and with indices
    above one. Every different bottom, and every pair of ``alpha`` and index, is projected,
    which takes seconds or minutes; a texture has at most 256 of these pairs. Codes are kept in
    memory. Textures are baked over the unit square of uv, which repeats.
    """

    PROPERTIES = (*COAT_PROPERTIES, "mipmaps")

    def _load(self, props):
        self._bottom = nested_bsdf(props)
        super()._load(props)
        self._mipmaps = switch_of(props, "mipmaps")
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
        check_coat(self._coat)
        check_nodes(self._bottom, self._coat.where)
        nested = surface_of(self._bottom)
        below = nested if isinstance(nested, PaperSurface) else None
        inner = below.codes.grid if below else ONE_TEXEL
        parts = self._coat.textures | ({} if below else {"the nested BSDF": self._bottom})
        chosen = choose(parts, inner, self._resolution, self._coat.where)
        coat = self._coat.layering(chosen.uv())
        codes = self.networks.layer(self._bottom_codes(below, chosen), coat)
        self.codes = CodeTexture(self.networks, codes, chosen, self._mipmaps)

    def _bottom_codes(self, below, grid):
        """Codes (T or 1, C, 32) of the bottom on a grid; below: it, if it has own codes."""
        if below and below.networks.fingerprint == self.networks.fingerprint:
            return below.codes.codes if below.codes.grid == ONE_TEXEL else _read(below.codes, grid)
        if grid == ONE_TEXEL or not varying_textures(self._bottom):
            return encode(self._bottom, self.networks).latents[None]
        pairs = projection_pairs()
        average = probing.needed_averaging(self._bottom, *pairs, grid.uv(), self._coat.where)
        values = partial(probing.texel_values, self._bottom, *pairs, average=average)
        parts = []
        for start in range(0, grid.texels, TEXELS):
            uv = grid.uv(start, min(start + TEXELS, grid.texels))
            f = probing.check_values(values(uv), self._coat.where)
            rows = f.reshape(-1, f.shape[-1])
            first, place = different_rows(rows)
            codes = self.networks.encode(rows[first])
            parts.append(codes[place].reshape(*f.shape[:2], LATENT))
        return np.concatenate(parts)

    def save(self, path):
        """Write the codes of a constant coat to a file that ``fan2022_brdf`` loads.

        Raises:
            ParameterError: the codes are a texture.
            FileError: the file cannot be written.
        """
        if self.codes.grid != ONE_TEXEL:
            raise ParameterError(f"{self._where}: textures of its codes cannot be saved")
        Material(self.codes.codes[0], self.networks).save(path)

    def traverse(self, callback):
        self._coat.traverse(callback, mi.ParamFlags.NonDifferentiable)
        callback.put("bottom", self._bottom, mi.ParamFlags.NonDifferentiable)

    def to_string(self):
        bottom = str(self._bottom).replace("\n", "\n  ")
        return f"PaperLayered[\n{self._coat},\n  bottom = {bottom}\n]"


def _read(below: CodeTexture, grid: TexelGrid) -> np.ndarray:
    """Codes (T, C, 32) of a textured bottom at the texels of a grid."""
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (grid.texels, 1)), grid.uv())
    return np.array([[z.numpy() for z in codes] for codes in below.vertex(si)]).transpose(2, 0, 1)


PLUGINS = PluginSet(
    lambda: {"fan2022_brdf": PaperBRDF, "fan2022_layered": PaperLayered},
    ("fan2022_brdf", "fan2022_layered"),
)
