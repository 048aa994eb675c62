"""Constant codes with gradients of their own numbers: values of the plain codes, and derivatives.

f has the same bits as without gradients. Only f is differentiated with respect to codes. Proposals
depend on detached codes: as in all of Mitsuba's differentiable integrators, samples are fixed while
the integrand changes.
"""

from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.networks.basis import BasisDecoder
from urushi.mitsuba.networks.lobe import ANY_LOBE
from urushi.mitsuba.recording import only_where


class DifferentiableLatents:
    """Codes with the gradients of a tensor; everything else is as in the plain latents."""

    def __init__(self, plain: ConstantLatents, tensor: "mi.TensorXf"):
        """tensor: the codes (C, L)."""
        self.model, self.plain, self.material = plain.model, plain, plain.material
        self.vertex, self.at, self.channels = plain.vertex, plain.at, plain.channels
        # Numbers that vanish or that channels share have gradients of their own.
        self._decoder = BasisDecoder(self.model, ANY_LOBE._replace(widths=self.model.widths))
        self._size, self._codes = tensor.shape[-1], tensor.array
        dr.make_opaque(self._codes)

    def f(self, vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._with_gradients(self.plain.f(vertex, si, wo, active), si, wo, active)

    def f_and_pdf(self, vertex, si, wo, active) -> tuple[list, Any]:
        """`f`, and the density of the proposal [1/sr]."""
        values, pdf = self.plain.f_and_pdf(vertex, si, wo, active)
        return self._with_gradients(values, si, wo, active), pdf

    def _code(self, channel) -> list:
        """The code (L) of a channel, an index. An argument of a nested call must be the result of
        an operation in the outer call, or Dr.Jit loses its gradient."""
        first = channel * self._size
        return [dr.gather(mi.Float, self._codes, first + i) for i in range(self._size)]

    def _with_gradients(self, values: list, si, wo, active) -> list:
        """Values with derivatives by the codes, besides their own derivatives by the directions."""
        if not dr.grad_enabled(self._codes):
            return values
        fine = self.channels == spectrum.COUNT
        places = spectrum.band_at(si.wavelengths) if fine else map(mi.UInt32, range(self.channels))
        codes, directions = [*map(self._code, places)], (dr.detach(si.wi), dr.detach(wo))
        changing = only_where(active, self._decoder.f, codes, *directions)
        pairs = zip(values, changing, strict=True)
        return [value + (change - dr.detach(change)) for value, change in pairs]
