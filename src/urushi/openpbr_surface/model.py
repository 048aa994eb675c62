"""The layers of OpenPBR Surface 1.1.1, opaque, in the order of its specification.

3.2    base substrate: a mixture of metal (3.2.1) and glossy-diffuse dielectric (3.2.2), whose
       facets a thin film (3.3) covers                                                   `Base`
3.4    coat: the darkening of the base (3.4.1) and absorption (3.4.2)  `Base.boost`, `absorbed`
3.5    fuzz above both                                                      `Fuzz`, `under_fuzz`

The light transport between the coat and the base is computed by `layered` or `neural_layered`, not
by a formula. Departures from the specification: a metal has the lobe of multiple scattering of
Kulla and Conty 2017, and the base follows refraction by the coat (`formulas.base_index`).
"""

from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.checks import Widths
from urushi.core import fresnel, microfacet
from urushi.core.appearance import optical_depth
from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.facets import MIRROR, multiple_lobe
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.surface import KnownSurface, bsdf_of
from urushi.mitsuba.tables import InterfaceAlbedo
from urushi.openpbr_surface import formulas, thin_film
from urushi.openpbr_surface.film import NAMES as film_parameters
from urushi.openpbr_surface.film import FilmFresnel
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.lookups import RoughSlab
from urushi.openpbr_surface.parameters import names_of
from urushi.openpbr_surface.parts import OfInputs

#: Least share of each lobe in the base's proposal.
MIN_SHARE = 0.1

#: Share of the proposal that fuzz leaves to what lies below, at the least.
LEAST_BELOW = 0.1

#: The parameters that the base reads, besides the film's; see `Base._configure`.
NAMES = (*names_of("base", "specular"), "coat_weight", "coat_ior", "coat_darkening")

#: The parameters on which the base's relative index depends.
INDICES = ("specular_ior", "coat_ior", "coat_weight", "specular_weight")


class BaseVertex(NamedTuple):
    """The base at a surface interaction."""

    color: Any  # base_weight times base_color
    tint: Any  # specular_color
    weight: Any  # specular_weight, at most one
    share: Any  # base_metalness
    widths: Any  # the GGX width, or `Widths` of an anisotropic interface
    alpha: Any  # one width for both
    eta: Any  # the index relative to the medium above


class Base(OfInputs):
    """The base substrate (3.2) without coat and fuzz, for directions in the medium above it.

    The dielectric's interface reflects by single scattering and passes the rest, so that a white
    base reflects all light.
    """

    def __init__(self, inputs: Inputs, under_coat: bool):
        """Leave out parts that parameters given as numbers do not need.

        under_coat: whether `coat_darkening` has an effect.
        """
        self._under_coat = under_coat
        super().__init__(inputs)

    def _configure(self):
        inputs = self._inputs
        self._boosted = self._under_coat and not inputs.is_constant("coat_darkening", 1)
        self._only_metal = inputs.is_constant("base_metalness", 1)
        self._only_dielectric = inputs.is_constant("base_metalness", 0)
        self._film = self._slab = None
        if not inputs.is_constant("thin_film_weight", 0):
            self._film = FilmFresnel(inputs)
        values = [inputs.known(name) for name in INDICES]
        # The index that `vertex` gives everywhere; None if it varies.
        eta = None if None in values else float(formulas.base_index(*values))
        two_widths = not inputs.is_constant("specular_roughness_anisotropy", 0)
        self._albedo = InterfaceAlbedo(eta, two_widths)
        self._mirror = InterfaceAlbedo(MIRROR, two_widths)
        if not inputs.is_constant("base_diffuse_roughness", 0):
            self._slab = RoughSlab(eta)
        tinted = self._boosted and not inputs.is_constant("coat_color", 1)
        film = film_parameters if self._film else ()
        self.names = (*NAMES, *(("coat_color",) if tinted else ()), *film)

    def _vertex(self, si, active) -> BaseVertex:
        at = self._inputs.at(si, active)
        ior, coat_ior, coat, weight = at.of(*INDICES)
        widths = at.widths("specular")
        alpha = 0.5 * (widths.u + widths.v) if isinstance(widths, Widths) else widths
        return BaseVertex(
            at.base_weight * at.base_color,
            at.specular_color,
            dr.minimum(weight, 1),
            at.base_metalness,
            widths,
            alpha,
            formulas.base_index(ior, coat_ior, coat, weight, DRJIT),
        )

    def _f(self, vertex: BaseVertex, ctx, si, wo, active):
        """A mixture of metal and dielectric by base_metalness (3.2)."""
        lobe, cosine = microfacet.reflection_lobe(si.wi, wo, vertex.widths)
        cosine = dr.abs(cosine)
        f = mi.Spectrum(0)
        if not self._only_metal:
            f += self.shine(vertex, lobe, cosine, si, active) + self.diffuse(vertex, si, wo, active)
        if not self._only_dielectric:
            metal = self._metal(vertex, lobe, cosine, si, wo, active)
            f = metal if self._only_metal else dr.lerp(f, metal, vertex.share)
        return mi.Spectrum(f * self.boost(vertex, si, active) if self._boosted else f)

    def _proposal(self, vertex: BaseVertex, si, active):
        share = mi.Float(1 - MIN_SHARE)
        if not self._only_metal:
            reflected = self.reflected(si.wi, vertex)
            color = dr.mean(vertex.color)
            share = reflected / (reflected + (1 - reflected) * color + 1e-4)
            share = dr.lerp(share, 1, vertex.share)
            share = dr.clip(share, MIN_SHARE, 1 - MIN_SHARE)
        return Mixture([share, 1 - share], [vertex.widths])

    def shine(self, vertex: BaseVertex, lobe, cosine, si, active):
        """What the interface of the dielectric (3.2.2), maybe under a film, reflects [1/sr]."""
        if self._film:
            reflectance = self._film.dielectric(cosine, vertex.eta, si, active)
        else:
            reflectance = fresnel.dielectric(cosine, vertex.eta)[0]
        return mi.Spectrum(lobe * reflectance * vertex.tint)

    def _metal(self, vertex: BaseVertex, lobe, cosine, si, wo, active):
        """Metal (3.2.1): GGX facets of the F82-tint term, with multiple scattering."""
        color, tint, widths = vertex.color, vertex.tint, vertex.widths
        reflectance = fresnel.f82(cosine, color, tint, DRJIT)
        mean = fresnel.f82_mean(color, tint, DRJIT)
        if self._film:
            reflectance = self._film.metal(cosine, color, tint, reflectance, si, active)
            mean = self._film.metal(mi.Float(thin_film.MEAN_COSINE), color, tint, mean, si, active)
        first, second, seen = (self._mirror.reflected(w, widths) for w in (si.wi, wo, None))
        return vertex.weight * (lobe * reflectance + multiple_lobe(first, second, seen, mean))

    def diffuse(self, vertex: BaseVertex, si, wo, active):
        """The interface passes light, the diffuse slab reflects it [1/sr]."""
        color, alpha, eta = vertex.color, vertex.alpha, vertex.eta
        passed = []  # of the light from wi and wo, and of diffuse light
        for w in (si.wi, wo, None):
            reflected = self.reflected(w, vertex)
            if self._film:
                seen, cosine = self._mirror.reflected(w, vertex.widths), None if w is None else w.z
                bare = dr.maximum(seen - reflected, 0)
                filmed = self._film.passing(bare, cosine, alpha, eta, si, active)
                reflected = seen - dr.clip(filmed, 0, seen)
            passed.append(1 - reflected)
        both, mean = passed[0] * passed[1], dr.maximum(passed[2], 1e-4)
        if self._slab is None:
            return color * (both * dr.inv_pi / mean)
        rough = self._inputs.at(si, active).base_diffuse_roughness
        return self._slab.f(si.wi, wo, color, rough, (alpha, eta), both, mean)

    def lobes(self, si) -> list[list]:
        """The numbers of the facets' lobe, see `urushi.nets.lobe`: a list for each channel.

        The dip of a metal's Fresnel term at 82 degrees, and light that meets more than one facet,
        are left out. Under a film the lobe is black, as it has none of the film's colours.
        """
        active = mi.Bool(True)
        vertex = self._vertex(si, active)
        color, share, widths = vertex.color, vertex.share, vertex.widths
        scale = mi.Spectrum(0) if self._film else self.boost(vertex, si, active)
        metal = scale * share * vertex.weight
        along, across = microfacet.pair(widths)
        values = (
            mi.Spectrum(along),
            dr.minimum(metal * color, 1),
            dr.minimum(metal * vertex.tint, 1),
            dr.minimum(scale * (1 - share) * vertex.tint, 1),
            mi.Spectrum(vertex.eta),
            mi.Spectrum(0),
            *([mi.Spectrum(across)] if isinstance(widths, Widths) else ()),
        )
        return [list(c) for c in zip(*values, strict=True)]

    def reflected(self, w, vertex: BaseVertex):
        """Share of light from w, or of diffuse light if it is None, that the interface reflects."""
        return self._albedo.reflected(w, vertex.widths, vertex.eta)

    def boost(self, vertex: BaseVertex, si, active):
        """The factor that cancels darkening by the coat (3.4.1), see `formulas.boost`; 1: none."""
        if not self._boosted:
            return mi.Spectrum(1)
        at = self._inputs.at(si, active)
        f0 = dr.square((vertex.eta - 1) / (vertex.eta + 1))
        dielectric, shine = f0 + (1 - f0) * vertex.color, vertex.weight * vertex.color
        albedo = dr.lerp(dielectric, shine, vertex.share)
        coat_eta = dr.maximum(at.coat_ior, 1.001)
        internal = formulas.internal(coat_eta, at.specular_roughness, vertex.share, f0)
        return formulas.boost(at.coat_darkening, internal, albedo, at.coat_color, DRJIT)

    def known(self):
        return KnownSurface(lobes=self.lobes, table_source=lambda: self)

    def replaced(self, replacement):
        """See `Surface.replaced`."""
        inputs = self._inputs.with_textures(replacement)
        return bsdf_of(type(self)(inputs, self._under_coat))


def absorbed(inputs: Inputs, f, si, wo, active):
    """f [1/sr] under the medium (3.4.2) of a coat of index one, which has no interface."""
    at = inputs.at(si, active)
    passed = dr.exp(-optical_depth(at.coat_color, DRJIT) * (1 / si.wi.z + 1 / wo.z))
    return f * dr.lerp(mi.Spectrum(1), passed, at.coat_weight)


class Fuzz(NamedTuple):
    """The fuzz (3.5) at a vertex, and the proposal of its lobe."""

    weight: Any  # fuzz_weight
    color: Any  # fuzz_color
    roughness: Any  # fuzz_roughness

    def hidden(self, w):
        """Share of the light from a direction that meets the fuzz."""
        return self.weight * formulas.fuzz_albedo(w.z, self.roughness, DRJIT)

    def share(self, wi):
        """Share of the proposal for light from wi."""
        return dr.minimum(self.hidden(wi), 1 - LEAST_BELOW)

    def lobe(self, seen, lit):
        """The lobe of a seen direction over the cosine of the other [1/sr]."""
        across = seen.x * lit.x + seen.y * lit.y
        return formulas.fuzz_density(seen.z, lit.z, across, self.roughness, DRJIT)

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        return dr.select(wo.z > 0, self.lobe(wi, wo) * wo.z, 0)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        a, c = formulas.fuzz_transform(wi.z, self.roughness, DRJIT)
        x, y, z = square_to_cosine_hemisphere(mi.Vector3f, u.x, u.y)
        return dr.normalize(mi.Vector3f(x - c * wi.x * z, y - c * wi.y * z, a * z))


def under_fuzz(fuzz: Fuzz, f, ctx, si, wo):
    """f [1/sr] with fuzz above it, which covers a fraction of the surface and passes the rest.

    The layers are weighted by the albedo of the direction that is seen, as in the specification
    (2.2), so that the sum is not reciprocal. The seen direction is si.wi, or wo of light that is
    traced from the emitters.
    """
    importance = ctx.mode == mi.TransportMode.Importance
    seen, lit = (wo, si.wi) if importance else (si.wi, wo)
    hidden = fuzz.hidden(seen)
    return f * (1 - hidden) + fuzz.color * (hidden * fuzz.lobe(seen, lit))
