"""Latent codes with gradients: values of the plain latents, derivatives of the codes.

f has the bits that it has without gradients. Its derivative is that of the decoded codes, which
are computed within the ranges of the parameters (`gradients`), so that f need not be their value.
Integrators evaluate a picture without derivatives first; no code is decoded then.

Only f is differentiated with respect to codes. Proposals depend on detached codes: as in all of
Mitsuba's differentiable integrators, samples are fixed while the integrand changes.
"""

from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi

from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.holders import ConstantLatents, TexturedLatents
from urushi.mitsuba.latents.lookup import drawn_texel, texel_draw
from urushi.mitsuba.networks.lobe import ANY_LOBE
from urushi.mitsuba.networks.protocols import decoder_and_sampler
from urushi.mitsuba.recording import only_where
from urushi.nets.weights import Model


class DifferentiableLatents:
    """Latents with the gradients of codes; everything else is that of the plain latents."""

    DRJIT_STRUCT: ClassVar = {"plain": object, "_codes": object}  # for frozen functions

    def __init__(
        self, model: Model, plain: ConstantLatents | TexturedLatents, tensor: "mi.TensorXf"
    ):
        """tensor: the codes, ([1,] C, size), or (height, width, C, size) of a texture."""
        self.plain = plain
        # Numbers that vanish or that channels share have gradients of their own.
        self._decoder, _ = decoder_and_sampler(model, ANY_LOBE._replace(widths=model.widths))
        self._size = tensor.shape[-1]
        if plain.grid is None:
            self.tensor, self._codes = tensor, tensor.array
            dr.make_opaque(self._codes)
            return
        numbers = plain.channels * self._size
        self.tensor = mi.TensorXf(tensor.array, (plain.grid.height, plain.grid.width, numbers))
        self._codes = self.tensor.array

    def __getattr__(self, name: str) -> Any:
        if name == "plain":  # while an instance is made
            raise AttributeError(name)
        return getattr(self.plain, name)

    def f(self, vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._with_gradients(self.plain.f(vertex, si, wo, active), si, wo, active)

    def f_and_pdf(self, vertex, si, wo, active) -> tuple[list, Any]:
        """`f`, and the density of the proposal [1/sr]."""
        values, pdf = self.plain.f_and_pdf(vertex, si, wo, active)
        return self._with_gradients(values, si, wo, active), pdf

    def codes(self, uv: "mi.Point2f", wi: "mi.Vector3f") -> list[list]:
        """Codes with gradients at points uv: of each channel a list (size) of Dr.Jit floats.

        Those of a texture are drawn as in `lookup`, seen from wi.
        """
        grid, count = self.plain.grid, self.plain.channels * self._size
        first = mi.UInt32(0)
        if grid is not None:
            (a, b, c), (d, e, f) = grid.to_texture
            point = a * uv.x + b * uv.y + c, d * uv.x + e * uv.y + f
            sizes = mi.Int32(grid.width), mi.Int32(grid.height)
            first = count * drawn_texel(point, sizes, grid, texel_draw(uv, wi))
        # Gathered at every call: an argument of a nested call must be the result of an operation in
        # the outer call, or Dr.Jit loses its gradient.
        numbers = [dr.gather(mi.Float, self._codes, first + i) for i in range(count)]
        return [numbers[i : i + self._size] for i in range(0, count, self._size)]

    def _codes_of_bands(self, si) -> list[list]:
        """The codes (size) of the band of each wavelength."""
        size = self._size
        return [
            [dr.gather(mi.Float, self._codes, band * size + i) for i in range(size)]
            for band in spectrum.band_at(si.wavelengths)
        ]

    def _with_gradients(self, values: list, si, wo, active) -> list:
        """Values with the derivatives by the codes; those by the directions are their own."""
        bands = self.plain.channels == spectrum.COUNT
        codes = self._codes_of_bands(si) if bands else self.codes(si.uv, si.wi)
        if not dr.grad_enabled(codes):
            return values
        directions = dr.detach(si.wi), dr.detach(wo)
        changing = only_where(active, self._decoder.f, codes, *directions)
        return [
            value + (change - dr.detach(change))
            for value, change in zip(values, changing, strict=True)
        ]
