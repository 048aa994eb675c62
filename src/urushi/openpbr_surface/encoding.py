"""The lobe of OpenPBR's base for codes, and when a coat takes a table instead."""

from collections.abc import Iterable

import drjit as dr
import mitsuba as mi

from urushi.checks import Widths
from urushi.core import fresnel
from urushi.core.namespace import DRJIT
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.bottoms import NARROW
from urushi.nets.lobe import NO_LOBE
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.model import Base

#: Cosines at which the Schlick lobe of a mixture is kept below the mixture's Fresnel term.
SCHLICK_COSINES = (0.6, 0.4, 0.25, 0.15, 0.05)

#: Factor on the Schlick lobe of a mixture. Networks expect a rest that is nowhere negative and has
#: a faint peak, as fitted lobes leave it.
SCHLICK_SHARE = 0.8

#: Least specular_roughness at which a constant, isotropic metal is encoded with the multiple
#: scattering between its facets. Other metals are encoded as one lobe: smooth metals scatter little
#: more than once, metals of two widths became up to 15 % too dark, and textures take too long.
MULTIPLE_FROM = 0.5

#: Least specular_roughness at which a constant coat over a constant, isotropic base with a film is
#: evaluated by a table, see `urushi.material.coated_table`. A smoother base would need its lobe
#: beside the table, and the lobe does not have the film's colours.
FILM_TABULATED_FROM = NARROW**0.5

#: The parameters of an isotropic metal besides its specular_roughness.
OF_METALS = ("base_weight", "base_color", "specular_weight", "specular_color")


def is_rough(inputs: Inputs, names: Iterable[str], least: float) -> bool:
    """Whether parameters are constant, the base isotropic and its roughness at least `least`."""
    return (
        inputs.is_uniform((*names, "specular_roughness", "specular_roughness_anisotropy"))
        and inputs.middle("specular_roughness_anisotropy") == 0
        and inputs.middle("specular_roughness") >= least
    )


def lobe(base: Base, si, bare: bool, compensated: bool) -> list[list]:
    """The base's lobe, six floats for each channel; seven of an anisotropic base.

    Metal and dielectric share one width, so that their mixture is one lobe. Its Fresnel term is the
    largest Schlick term that does not exceed the mixture's: the layering network fails for some
    sums of a Schlick and an exact term. The rest contains the dip of a metal's Fresnel term at 82
    degrees, and multiple scattering between the facets of a rough metal.

    Args:
        base: the base. si: the surface interactions.
        bare: whether the base counts as its lobe alone.
        compensated: whether the coated base gets back lost energy. If not, a bare metal is scaled
            to the energy of its multiple scattering (Turquin 2019).
    """
    active = mi.Bool(True)
    vertex = base.vertex(si, active)
    color, tint, weight, share, alpha, _, eta = vertex
    scale = base.boost(vertex, si, active)
    if bare and not compensated:
        scale *= base.mirror.gain(alpha, color)
    if base.film:
        color = base.film.metal_in_coat(color, tint, si, active)
    along, across = (alpha.u, [alpha.v]) if isinstance(alpha, Widths) else (alpha, [])
    dielectric = share == 0
    normal, grazing = _schlick_below(
        lambda c: vertex.mixed(fresnel.dielectric(c, eta)[0], fresnel.f82(c, color, tint, DRJIT))
    )
    metals = (share == 1) & mi.Bool(bare)
    normal = dr.select(metals, weight * color, normal)
    grazing = dr.select(metals, weight * tint, grazing)
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


def _schlick_below(reflectance):
    """Factors (normal, grazing) of Schlick's form, `SCHLICK_SHARE` of a reflectance at normal
    incidence, and not above it at `SCHLICK_COSINES`."""
    normal, grazing = reflectance(mi.Float(1)), mi.Spectrum(1)
    for cosine in SCHLICK_COSINES:
        share = (1 - cosine) ** 5
        bound = (reflectance(mi.Float(cosine)) - normal * (1 - share)) / share
        grazing = dr.minimum(grazing, bound)
    return SCHLICK_SHARE * normal, SCHLICK_SHARE * dr.maximum(grazing, 0)
