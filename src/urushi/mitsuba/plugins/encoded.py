"""Surfaces that are given by latent codes."""

from typing import NamedTuple

from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents
from urushi.mitsuba.latents.codes import ConstantLatents, Vertex
from urushi.mitsuba.plugins.frames import Turn, TurnedMixture, turned
from urushi.mitsuba.surface import KnownSurface, Surface
from urushi.nets.weights import Model


class PlacedVertex(NamedTuple):
    """The vertex of codes at a surface interaction."""

    turn: Turn | None  # of the tangent about the normal, if there is one
    vertex: Vertex  # of the codes, in the turned frame


class EncodedSurface(Surface):
    """A surface given by latent codes; subclasses set `model` and `latents`."""

    model: Model
    latents: ConstantLatents | AxisLatents
    _colors = False  # whether three channels are colours, see `spectrum.from_channels`

    def known(self):
        return KnownSurface(self.latents)

    def _turn(self, si, active) -> Turn | None:
        """The turn of the tangent, if there is one."""

    def _vertex(self, si, active):
        turn = self._turn(si, active)
        inside = si if turn is None else turn.interaction(si)
        return PlacedVertex(turn, self.latents.vertex(inside, active))

    def _f(self, vertex, ctx, si, wo, active):
        si, wo = turned(vertex.turn, si, wo)
        channels = self.latents.f(vertex.vertex, si, wo, active)
        return self._spectrum(channels, si)

    def _proposal(self, vertex, si, active):
        proposal = vertex.vertex.proposal
        return proposal if vertex.turn is None else TurnedMixture(proposal, vertex.turn)

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        si, wo = turned(vertex.turn, si, wo)
        channels, pdf = self.latents.f_and_pdf(vertex.vertex, si, wo, active)
        return self._spectrum(channels, si), pdf

    def _spectrum(self, channels, si):
        return spectrum.from_channels(channels, si.wavelengths, colors=self._colors)
