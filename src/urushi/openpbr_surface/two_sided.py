"""Parts of a surface that transmits light, in closed form: the interface of a body, thin walls.

The interface returns the light that it loses. Thin walls scatter light to both sides, as leaves and
paper do.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.checks import MIN_INDEX_STEP
from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect, refract
from urushi.core.facets import MIRROR
from urushi.core.mixture import Mixture
from urushi.errors import ParameterError
from urushi.mitsuba.frames import SlabMixture, above_surface, raised, relative, with_far_side
from urushi.mitsuba.tables import InterfaceAlbedo
from urushi.openpbr_surface import model
from urushi.openpbr_surface.bsdfs import SPREAD, SurfaceProposal
from urushi.openpbr_surface.film import NAMES as film_parameters
from urushi.openpbr_surface.film import FilmFresnel
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parameters import names_of
from urushi.openpbr_surface.parts import INDICES, OfInputs, index2, index_of, tint_of
from urushi.walk import interface

#: Least share of the proposal for light that meets more than one facet.
LEAST_LOST = 0.01


class Facets(NamedTuple):
    """Facets seen from wi, which reflect a share of the light and refract the rest."""

    widths: Any
    eta: Any  # index on the far side relative to wi's
    reflected: Callable[[Any], Any]  # the share, by the cosine to the facet

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        a, b = raised(wi), relative(wi, wo)
        facet = dr.normalize(a + dr.select(b.z > 0, 1, self.eta) * b)
        cosine = dr.abs(dr.dot(a, facet))
        share = self.reflected(cosine)
        near = microfacet.visible_normal_pdf(a, facet, self.widths) / (4 * cosine)
        far = interface.transmission(a, b, self.widths, self.eta)[1]
        return dr.select(b.z > 0, near * share, far * (1 - share))

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`. It is at the horizon where facets send light nowhere."""
        a = raised(wi)
        facet = microfacet.sample_visible_normal(a, self.widths, u.x, u.y)
        cosine = dr.dot(a, facet)
        reflects, inside = choice < self.reflected(cosine), fresnel.dielectric(cosine, self.eta)[1]
        wo = dr.select(reflects, reflect(a, facet), refract(a, facet, inside, self.eta))
        return relative(wi, dr.select((wo.z > 0) == reflects, wo, mi.Vector3f(1, 0, 0)))


class GlassVertex(NamedTuple):
    """`Glass` at a surface interaction."""

    widths: Any  # as of `model.BaseVertex`
    eta: Any  # index on the far side relative to wi's
    tint: Any  # of transmitted light
    specular: Any  # specular_color
    lost: Any  # share of the light from wi that meets a second facet
    scale: Any  # of the product of lost shares, a lobe [1/sr]


class Unseen:
    """What has no interface that bends light: light goes straight on through a coloured medium."""

    names = ("transmission_color", "coat_color", "coat_ior", *INDICES)

    def __init__(self, inputs: Inputs, coated: bool):
        self._inputs, self._coated = inputs, coated

    @staticmethod
    def is_right(inputs: Inputs, coated: bool) -> bool:
        """Whether a body or a pane, and the coat on it, have the index of what lies outside."""
        indices = [index_of(inputs), *([inputs.known("coat_ior")] if coated else ())]
        return not any(x is None or abs(x - 1) >= MIN_INDEX_STEP for x in indices) and (
            inputs.thin or inputs.is_constant("thin_film_weight", 0)
        )

    def passed(self, si, active) -> Any:
        """Transmittance along si.wi: the colours are those of light along the normal."""
        inputs, at, tint = self._inputs, self._inputs.at(si, active), mi.Spectrum(1)
        coat = at.coat_color if self._coated else tint
        if inputs.thin:  # the medium of the pane and two coats, each of the root of its colour
            slab = at.transmission_color * coat
        else:
            tint, slab = tint_of(inputs, at), dr.sqrt(coat)
        return tint * dr.power(slab, 1 / dr.maximum(dr.abs(si.wi.z), 1e-6))


class Glass(OfInputs):
    """The surface of a body whose medium transmits light (3.2.4)."""

    def _configure(self):
        index = index_of(self._inputs)
        if abs(index - 1) < MIN_INDEX_STEP:
            raise ParameterError(
                f"{self._inputs.where}: thin_film_weight needs a film on a body of index 1, "
                "which the plugin does not support; leave it out or give another specular_ior"
            )
        self._transmit(index)
        two_widths = not self._inputs.is_constant("specular_roughness_anisotropy", 0)
        self._sides = [(eta, InterfaceAlbedo(eta, two_widths)) for eta in (index, 1 / index)]
        film = not self._inputs.is_constant("thin_film_weight", 0)
        self._film: Any = FilmFresnel(self._inputs, transmits=True) if film else None
        self._mirror: Any = InterfaceAlbedo(MIRROR, two_widths) if film else None
        bare = film or self._inputs.is_constant("coat_weight", 0)  # a film may appear
        of_film = film_parameters if bare else ()
        self.names = (*names_of("specular"), "transmission_color", *of_film)

    def _vertex(self, si, active):
        at = self._inputs.at(si, active)
        widths = at.widths("specular")
        above, below = (self._not_kept(widths, None, x, si, active) for x in (True, False))
        scale = 1 / dr.maximum(dr.pi * (above + self._index**2 * below), 1e-5)
        lost = self._lost(widths, si.wi, si, active)
        eta, tint = self._index_across(si.wi), tint_of(self._inputs, at)
        return GlassVertex(widths, eta, tint, at.specular_color, lost, scale)

    def _lost(self, widths, w, si, active):
        """Share of the light from a direction that meets a second facet."""
        return dr.clip(self._not_kept(widths, raised(w), w.z > 0, si, active), 0, 1)

    def _not_kept(self, widths, w, above, si, active):
        """What single scattering does not return of the light from w, raised; None: diffuse light.

        above: whether the light is above the surface.
        """
        sides = [table.both(w, widths, eta) for eta, table in self._sides]
        reflected, passed = (dr.select(above, *pair) for pair in zip(*sides, strict=True))
        if not self._film:
            return 1 - reflected - passed
        along, across = microfacet.pair(widths)
        at = None if w is None else w.z, 0.5 * (along + across), mi.Float(self._index), si, active
        seen = self._mirror.reflected(w, widths)
        kept = seen - reflected  # of light that facets reflect, if they reflected all
        # What is kept and what passes are both about proportional to what the facets transmit.
        return (1 - seen) + self._film.passing(kept - passed, *at, above=above)

    def _f(self, vertex, ctx, si, wo, active):
        above, through = si.wi.z > 0, si.wi.z * wo.z < 0
        a, b = raised(si.wi), relative(si.wi, wo)
        lobe, cosine = microfacet.reflection_lobe(a, b, vertex.widths)
        reflected = self._fresnel(dr.abs(cosine), vertex.eta, above, si, active)
        passed = mi.Spectrum(interface.transmission(a, b, vertex.widths, vertex.eta)[0])
        if self._film:
            facet = dr.abs(dr.dot(a, dr.normalize(a + vertex.eta * b)))
            unfilmed = 1 - fresnel.dielectric(facet, vertex.eta)[0]
            filmed = 1 - self._fresnel(facet, vertex.eta, above, si, active)
            passed *= filmed / dr.maximum(unfilmed, 1e-6)
        reflected *= lobe * dr.select(above, vertex.specular, 1)
        # Light that would meet a second facet leaves on both sides (Kulla and Conty 2017).
        lost = vertex.lost * self._lost(vertex.widths, wo, si, active) * vertex.scale
        f = dr.select(through, passed, reflected) + lost * index2(wo, self._index)
        f *= dr.select(through, vertex.tint, 1)
        if ctx.mode == mi.TransportMode.Importance:
            return f
        return f / dr.select(through, dr.square(vertex.eta), 1)

    def _fresnel(self, cosine, eta, above, si, active):
        """The Fresnel term of a facet; under the film, it is the same on both sides."""
        bare, outside = fresnel.dielectric(cosine, eta)
        if not self._film:
            return mi.Spectrum(bare)
        outside = dr.select(above, cosine, dr.maximum(outside, 0))
        film = self._film.dielectric(outside, mi.Float(self._index), si, active)
        return dr.select(above | (outside > 0), film, 1)

    def _proposal(self, vertex, si, active):
        def reflected(cosine):
            return dr.mean(self._fresnel(cosine, vertex.eta, si.wi.z > 0, si, active))

        lost = dr.clip(dr.mean(mi.Spectrum(vertex.lost)), LEAST_LOST, 0.9)
        facets = Facets(vertex.widths, vertex.eta, reflected)
        return SurfaceProposal([(facets, 1 - lost), (SlabMixture(SPREAD, SPREAD, 0.5, 1.0), lost)])

    def _update(self, keys):
        self._configure()


class Sheet(OfInputs):
    """A thin wall of a medium that scatters light to both sides, below interfaces (3.2.3)."""

    names = (
        *("subsurface_color", "subsurface_scatter_anisotropy", "base_diffuse_roughness"),
        *names_of("specular"),
    )

    def _configure(self):
        self._base = model.Base(self._inputs, False)
        self._transmit()

    def _vertex(self, si, active):
        at, vertex = self._inputs.at(si, active), self._base._vertex(si, active)
        forward = 0.5 + 0.5 * at.subsurface_scatter_anisotropy
        return vertex._replace(color=at.subsurface_color), forward

    def _f(self, vertex, ctx, si, wo, active):
        base, forward = vertex
        through, wo, si = si.wi.z * wo.z < 0, raised(wo), above_surface(si)
        # Shares of one diffuse lobe: a rough one is not linear in its colour.
        diffuse = self._base.diffuse(base, si, wo, active)
        lobe, cosine = microfacet.reflection_lobe(si.wi, wo, base.widths)
        shine = self._base.shine(base, lobe, dr.abs(cosine), si, active)
        return dr.select(through, forward * diffuse, shine + (1 - forward) * diffuse)

    def _proposal(self, vertex, si, active):
        base, forward = vertex
        reflected = self._base.reflected(raised(si.wi), base)
        through = dr.clip((1 - reflected) * forward, 0, 1 - model.MIN_SHARE)
        share = dr.clip(reflected / (1 - through), model.MIN_SHARE, 1 - model.MIN_SHARE)
        return with_far_side(Mixture([share, 1 - share], [base.widths]), through)
