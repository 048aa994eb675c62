"""The base of OpenPBR: metal and glossy-diffuse dielectric, in closed form."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core import fresnel, metal, microfacet
from urushi.core.mixture import Mixture
from urushi.mitsuba import spectrum
from urushi.nets.lobe import NO_LOBE
from urushi.openpbr import darkening, roughness
from urushi.openpbr.inputs import Inputs
from urushi.openpbr.plugins.albedo import (
    AnisotropicInterface,
    AnisotropicMirror,
    InterfaceAlbedo,
    MirrorAlbedo,
)
from urushi.openpbr.plugins.film import FilmFresnel
from urushi.openpbr.plugins.slab import RoughSlab, Slab

#: Least share of each lobe in the proposal.
MIN_SHARE = 0.1

#: The parameters on which its relative index depends.
INDICES = ("specular_ior", "coat_ior", "coat_weight", "specular_weight")

#: specular_roughness below which networks take the inverse of an index below one, which reflects
#: as much at normal incidence: they do not represent the edge of sharp total reflection over a
#: bright slab.
INVERTED_BELOW = 0.3

#: Greatest base_diffuse_roughness that networks encode. They have not learned what scatters further
#: back, and darken it by up to 25 %; a coat hides most of the difference.
ENCODED_DIFFUSE_ROUGHNESS = 0.5

#: Cosines at which the lobe of a mixture is not above the mixture.
SCHLICK_COSINES = (0.6, 0.4, 0.25, 0.15, 0.05)

#: Share of that lobe that is taken out. Networks expect a rest that is nowhere below zero and has a
#: faint peak, as fitted lobes leave it.
SCHLICK_SHARE = 0.8

#: specular_roughness from which networks encode a constant, isotropic metal with what its facets
#: reflect more than once. They see the lobe alone of other metals: smooth ones lose little, those
#: of two widths became up to 15 % too dark, and textures would take long to encode.
MULTIPLE_FROM = 0.5

#: specular_roughness from which a coat over a constant, isotropic base takes a table of it.
TABULATED_FROM = 0.15

#: The parameters of an isotropic metal besides its specular_roughness.
OF_METALS = ("base_weight", "base_color", "specular_weight", "specular_color")

#: The parameters that the base reads.
NAMES = (
    *("base_weight", "base_color", "base_diffuse_roughness", "base_metalness"),
    *("specular_weight", "specular_color", "specular_roughness", "specular_ior"),
    *("specular_roughness_anisotropy", "coat_weight", "coat_ior", "coat_darkening"),
)


class Vertex(NamedTuple):
    """The base at a surface interaction.

    Attributes:
        color: base_weight times base_color. tint: specular_color.
        weight: specular_weight, at most one. share: base_metalness.
        widths: the GGX width, or `Widths` of an anisotropic interface; alpha: one for both.
        eta: the index relative to the medium above.
    """

    color: Any
    tint: Any
    weight: Any
    share: Any
    widths: Any
    alpha: Any
    eta: Any


def define(base: type) -> type:
    """Make the class in the current variant; base: of `define_proposal_bsdf`."""

    class OpenPBRBase(base):
        """The base without coat and fuzz, for directions in the medium above it.

        The interface reflects by single scattering and passes the rest, so that a white base
        reflects all light. A metal has the lobe of multiple scattering of Kulla and Conty 2017.
        """

        def __init__(self, inputs: Inputs, under_coat: bool, encoded: bool, compensated: bool):
            """Take the parameters.

            under_coat: whether `coat_darkening` has an effect.
            encoded: whether networks encode it; see `INVERTED_BELOW` and
                `ENCODED_DIFFUSE_ROUGHNESS`.
            compensated: whether the coated base is completed, so that a metal's lobe is not scaled.
            """
            super().__init__(mi.Properties("openpbr_base"))
            self._where = inputs.where
            self._inputs, self._under_coat = inputs, under_coat
            self._encoded, self._compensated = encoded, compensated
            self._configure()
            self._kept.keep(self)

        def _configure(self):
            """Leave out what parameters that are given as numbers do not need."""
            inputs = self._inputs
            self._version = inputs.version
            self._boosted = self._under_coat and not inputs.is_constant("coat_darkening", 1)
            self._only_metal = inputs.is_constant("base_metalness", 1)
            self._only_dielectric = inputs.is_constant("base_metalness", 0)
            self._film = self._slab = self._turning = None
            if not inputs.is_constant("thin_film_weight", 0):
                self._film = FilmFresnel(inputs)
            eta = self._constant_eta()
            self._albedo, self._mirror = InterfaceAlbedo(eta), MirrorAlbedo()
            if not inputs.is_constant("base_diffuse_roughness", 0):
                self._slab = RoughSlab(eta)
            if not inputs.is_constant("specular_roughness_anisotropy", 0):
                self._mirror = AnisotropicMirror()
                self._turning = AnisotropicInterface(self._albedo, self._mirror)

        def _constant_eta(self) -> float | None:
            """The index relative to the medium above if it is constant."""
            values = [self._inputs.known(name) for name in INDICES]
            if any(value is None for value in values):
                return None
            values[:2] = np.maximum(values[:2], roughness.LEAST_INDEX)
            eta = float(roughness.base_index(*values))
            if self._encoded and eta < 1:
                rough = self._inputs.known("specular_roughness")
                if rough is None:
                    return None
                eta = 1 / eta if rough < INVERTED_BELOW else eta
            return eta

        def update(self) -> None:
            """Make what was left out and is needed since parameters have changed."""
            self._inputs.refresh()
            if self._version != self._inputs.version:
                self._configure()

        def _vertex(self, si, active) -> Vertex:
            inputs = self._inputs
            widths = self._alpha(si, active)
            return Vertex(
                inputs.number("base_weight", si, active) * inputs.color("base_color", si, active),
                inputs.color("specular_color", si, active),
                dr.minimum(inputs.number("specular_weight", si, active), 1),
                inputs.number("base_metalness", si, active),
                widths,
                _mean_width(widths),
                self._eta(si, active),
            )

        def _f(self, vertex, ctx, si, wo, active):
            color, tint, widths = vertex.color, vertex.tint, vertex.widths
            lobe, cos_m = microfacet.reflection_lobe(si.wi, wo, widths)
            cos_m, f = dr.abs(cos_m), mi.Spectrum(0)
            if not self._only_metal:
                f += lobe * self._dielectric(cos_m, vertex.eta, si, active) * tint
                f += self._diffuse(si, wo, vertex, active)
            if not self._only_dielectric:
                reflectance, mean = (
                    metal.f82(cos_m, color, tint, dr),
                    metal.f82_mean(color, tint, dr),
                )
                if self._film:
                    reflectance = self._film.metal(cos_m, color, tint, reflectance, si, active)
                    mean = self._film.metal_mean(color, tint, mean, si, active)
                first, second = (self._mirror.seen(w, widths) for w in (si.wi, wo))
                shine = vertex.weight * (
                    lobe * reflectance + self._mirror.lost(first, second, widths, mean)
                )
                f = shine if self._only_metal else dr.lerp(f, shine, vertex.share)
            if self._boosted:
                f *= self._boost(si, vertex, active)
            return f

        def _diffuse(self, si, wo, vertex, active):
            """What passes the interface, is reflected by the slab and leaves [1/sr]."""
            color, alpha, eta = vertex.color, vertex.alpha, vertex.eta
            reflected = [self._reflected(w, vertex) for w in (si.wi, wo)]
            mean = self._reflected_mean(vertex)
            if self._film and not self._encoded:
                for i, w in enumerate((si.wi, wo)):
                    more = self._film.excess(w.z, alpha, eta, si, active)
                    reflected[i] = dr.clip(
                        reflected[i] + self._mirror.seen(w, vertex.widths) * more, 0, 1
                    )
                more = self._mirror.seen_mean(vertex.widths) * self._film.mean_excess(
                    alpha, eta, si, active
                )
                mean = dr.clip(mean + more, 0, 1)
            passed, mean = (1 - reflected[0]) * (1 - reflected[1]), 1 - mean
            if self._slab is None:
                return color * (passed * dr.inv_pi / mean)
            rough = self._inputs.number("base_diffuse_roughness", si, active)
            if self._encoded:
                rough = dr.minimum(rough, ENCODED_DIFFUSE_ROUGHNESS)
            return self._slab.f(si.wi, wo, Slab(color, rough, alpha, eta, passed, mean))

        def _reflected(self, w, vertex):
            """Share of the light from a direction that the interface reflects."""
            if self._turning:
                return self._turning.reflected(w, vertex.widths, vertex.eta)
            return self._albedo.reflected(w.z, vertex.alpha, vertex.eta)

        def _reflected_mean(self, vertex):
            """Share of diffuse light that the interface reflects."""
            if self._turning:
                return self._turning.reflected_mean(vertex.widths, vertex.eta)
            return self._albedo.reflected_mean(vertex.alpha, vertex.eta)

        def _dielectric(self, cosine, eta, si, active):
            """The Fresnel term of the dielectric; networks take it without the film."""
            if self._film and not self._encoded:
                return self._film.dielectric(cosine, eta, si, active)
            return fresnel.dielectric(cosine, eta)[0]

        def _boost(self, si, vertex, active):
            """The factor that takes back darkening, see `urushi.openpbr.darkening`."""
            inputs = self._inputs
            f0 = dr.square((vertex.eta - 1) / (vertex.eta + 1))
            dielectric, shine = f0 + (1 - f0) * vertex.color, vertex.weight * vertex.color
            base = darkening.Base(
                dr.lerp(dielectric, shine, vertex.share),
                inputs.number("specular_roughness", si, active),
                vertex.share,
                f0,
            )
            coat_eta = dr.maximum(inputs.number("coat_ior", si, active), 1.001)
            kept = inputs.number("coat_darkening", si, active)
            return darkening.boost(kept, coat_eta, base, dr)

        def _proposal(self, vertex, si, active):
            share = mi.Float(1 - MIN_SHARE)
            if not self._only_metal:
                reflected = self._reflected(si.wi, vertex)
                color = dr.mean(vertex.color)
                share = reflected / (reflected + (1 - reflected) * color + 1e-4)
                share = dr.lerp(share, 1, vertex.share)
                share = dr.clip(share, MIN_SHARE, 1 - MIN_SHARE)
            return Mixture([share, 1 - share], [vertex.widths])

        @property
        def bare(self) -> bool:
            """Whether the base counts as its lobe alone: a metal, but for its dip at 82 degrees."""
            return self._only_metal and not is_rough_constant(self._inputs)

        @property
        def tabulated(self):
            """The base without the limits of networks, of which a coat takes a table; None: coats
            take codes.

            A constant coat over a constant, isotropic base takes a table, see
            `urushi.material.coated_table`. The lobe of a smooth base is too narrow for a table.
            """
            if not (self._encoded and is_rough(self._inputs, NAMES, TABULATED_FROM)):
                return None
            return type(self)(self._inputs, self._under_coat, False, self._compensated)

        def lobes(self, si):
            """The base's lobe, six floats for each channel; seven of an anisotropic base.

            Metal and dielectric share one width, so that their mixture is one lobe. Its Fresnel
            term is the greatest of Schlick's form that lies below the mixture's: sums of Schlick's
            and an exact one are unknown to the networks, which return nonsense for some. The dip
            of a metal's Fresnel term at 82 degrees is left to the rest, and so is what the facets
            of a rough metal reflect more than once, see `MULTIPLE_FROM`. Another metal is scaled to
            the energy of its multiple scattering (Turquin 2019), unless that is given back to the
            coated base.
            """
            active = mi.Bool(True)
            vertex = self._vertex(si, active)
            color, tint, weight, share, alpha, _, eta = vertex
            scale = self._boost(si, vertex, active) if self._boosted else mi.Spectrum(1)
            if self.bare and not self._compensated:
                scale *= self._mirror.gain(alpha, color)
            if self._film:
                color = self._film.metal_in_coat(color, tint, si, active)
            along, across = (alpha.u, [alpha.v]) if isinstance(alpha, Widths) else (alpha, [])
            dielectric = share == 0
            normal, grazing = weight * color, weight * tint
            mixed = _schlick_below(
                lambda c: dr.lerp(
                    tint * fresnel.dielectric(c, eta)[0],
                    weight * metal.f82(c, color, tint, dr),
                    share,
                )
            )
            metals = (share == 1) & mi.Bool(self.bare)
            normal = dr.select(metals, normal, mixed[0])
            grazing = dr.select(metals, grazing, mixed[1])
            values = (
                mi.Spectrum(along),
                dr.select(dielectric, 0, dr.minimum(scale * normal, 1)),
                dr.select(dielectric, 0, dr.minimum(scale * grazing, 1)),
                dr.select(dielectric, dr.minimum(scale * tint, 1), 0),
                dr.select(dielectric, mi.Spectrum(eta), NO_LOBE[4]),
                mi.Spectrum(0),
                *map(mi.Spectrum, across),
            )
            return [list(c) for c in zip(*map(spectrum.to_channels, values), strict=True)]

        def below_coat(self, f, si, wo, active):
            """f [1/sr] for a coat over this base, of networks with the film's change of colour.

            See `FilmFresnel.below_coat`.
            """
            if not self._film or not self._encoded:
                return f
            vertex = self._vertex(si, active)
            eta = self._relative_index(si, active)
            return self._film.below_coat(f, vertex, eta, si, wo, active)

        def _alpha(self, si, active):
            """The GGX width, or `Widths` of an anisotropic interface."""
            rough = self._inputs.number("specular_roughness", si, active)
            if self._turning is None:
                return roughness.lobe_width(rough, dr)
            bias = self._inputs.number("specular_roughness_anisotropy", si, active)
            return Widths(*roughness.lobe_widths(rough, bias, dr))

        def _eta(self, si, active):
            """The index relative to the medium above, as networks take it."""
            eta = self._relative_index(si, active)
            if self._encoded:
                rough = self._inputs.number("specular_roughness", si, active)
                eta = dr.select((rough < INVERTED_BELOW) & (eta < 1), 1 / eta, eta)
            return dr.clip(eta, 1 / 3, 3)

        def _relative_index(self, si, active):
            """The index relative to the medium above."""
            ior, coat_ior, coat, weight = (
                self._inputs.number(name, si, active) for name in INDICES
            )
            ior, coat_ior = (
                dr.maximum(ior, roughness.LEAST_INDEX),
                dr.maximum(coat_ior, roughness.LEAST_INDEX),
            )
            return dr.clip(roughness.base_index(ior, coat_ior, coat, weight, dr), 1 / 3, 3)

        def traverse(self, callback):
            for name in NAMES:
                callback.put(name, self._inputs.textures[name], mi.ParamFlags.Differentiable)
            if self._film:
                self._film.traverse(callback)

        def _update(self, keys):
            self.update()

        def to_string(self):
            return "OpenPBRBase[]"

    return OpenPBRBase


def is_rough_constant(inputs: Inputs) -> bool:
    """Whether a metal is constant, isotropic and rough; see `MULTIPLE_FROM`."""
    return is_rough(inputs, OF_METALS, MULTIPLE_FROM)


def is_rough(inputs: Inputs, names: Iterable[str], least: float) -> bool:
    """Whether parameters are constant, the base isotropic and its roughness at least `least`."""
    return (
        inputs.is_uniform((*names, "specular_roughness", "specular_roughness_anisotropy"))
        and inputs.middle("specular_roughness_anisotropy") == 0
        and inputs.middle("specular_roughness") >= least
    )


def _schlick_below(reflectance):
    """Factors (normal, grazing) of Schlick's form, `SCHLICK_SHARE` of a reflectance at normal
    incidence, and not above it at `SCHLICK_COSINES`."""
    normal, grazing = reflectance(mi.Float(1)), mi.Spectrum(1)
    for cosine in SCHLICK_COSINES:
        share = (1 - cosine) ** 5
        bound = (reflectance(mi.Float(cosine)) - normal * (1 - share)) / share
        grazing = dr.minimum(grazing, bound)
    return SCHLICK_SHARE * normal, SCHLICK_SHARE * dr.maximum(grazing, 0)


def _mean_width(alpha):
    """One width that stands for two in the albedos: their mean."""
    return 0.5 * (alpha.u + alpha.v) if isinstance(alpha, Widths) else alpha
