"""Surfaces that are given by latent codes."""

from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.surface import KnownSurface, Surface
from urushi.nets.weights import Model


class EncodedSurface(Surface):
    """A surface given by latent codes; subclasses set `model` and `latents`."""

    model: Model
    latents: ConstantLatents | AxisLatents
    _colors = False  # whether three channels are colours, see `spectrum.from_channels`

    def known(self):
        return KnownSurface(self.latents)

    def _vertex(self, si, active):
        return self.latents.vertex(si, active)

    def _proposal(self, vertex, si, active):
        return vertex.proposal

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        channels, pdf = self.latents.f_and_pdf(vertex, si, wo, active)
        return spectrum.from_channels(channels, si.wavelengths, colors=self._colors), pdf
