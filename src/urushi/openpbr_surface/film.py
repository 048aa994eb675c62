"""Thin-film iridescence of OpenPBR's base (section 3.3): its Fresnel terms under a film.

The directional albedo of an interface is a mean, over visible facets, of the reflectance times
masking. The film's reflectance is known only during rendering. It is evaluated at the nodes of a
Gauss rule, which is exact for polynomials in the cosine to the facet.
"""

import functools

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import albedos, fresnel
from urushi.core.facets import MIRROR
from urushi.core.namespace import DRJIT
from urushi.core.quadrature import gauss
from urushi.material.crossing import in_plane, mirrored
from urushi.mitsuba.recording import compiled_once
from urushi.mitsuba.tables import InterfaceAlbedo, Interpolated, albedo_coordinates
from urushi.openpbr_surface import formulas, thin_film
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parameters import names_of

#: The parameters that the film reads.
NAMES = names_of("thin_film")

#: The parameters on which the film's relative index depends.
_INDICES = ("thin_film_ior", "coat_ior", "coat_weight")

#: Least reflectance in a division.
_LEAST = 1e-4

#: Nodes of a Gauss rule, and in each dimension of the quadrature over facets that makes it.
NODES, FINE = 4, 40


class FilmFresnel:
    """Fresnel terms with the film, which covers the share `thin_film_weight` of the facets.

    The channels' sensitivities are linear sRGB in colour variants, single wavelengths in spectral
    variants, and Y in monochromatic variants.
    """

    def __init__(self, inputs: Inputs):
        self._inputs = inputs
        self._rule, self._mean_rule = map(Interpolated, rules())
        indices = [inputs.known(name) for name in _INDICES]
        self._mirror, self._total = InterfaceAlbedo(MIRROR), None
        if any(x is None for x in indices) or formulas.relative_index(*indices) < 1:
            self._total = InterfaceAlbedo(None)

    def dielectric(self, cosine, eta, si, active):
        """The term of a dielectric of index eta relative to the medium above, a spectrum."""
        bare = fresnel.dielectric(cosine, eta)[0]
        filmed = self._filmed(cosine, self._film(si, active), eta, si)
        return dr.lerp(mi.Spectrum(bare), filmed, self._weight(si, active))

    def metal(self, cosine, f0, tint, bare, si, active):
        """The term of a metal of `bare` reflectance without film, a spectrum."""
        film, values = self._film(si, active), []
        for i, response in enumerate(self._responses(si.wavelengths)):
            below = thin_film.metal_index(f0[i], tint[i], DRJIT)
            values.append(thin_film.reflectance(cosine, film, below, response, DRJIT))
        return dr.lerp(mi.Spectrum(bare), mi.Spectrum(*values), self._weight(si, active))

    def facets(self, cosine, alpha):
        """Cosines and weights of a Gauss rule of `rules`, for a direction; None: diffuse light."""
        rule = self._mean_rule if cosine is None else self._rule
        found = rule(albedo_coordinates(cosine, alpha, None))
        return zip(found[:NODES], found[NODES:], strict=True)

    def mean(self, cosine, alpha, eta, bare, si, active):
        """Mean reflectance of the facets seen from a direction, a spectrum; weighted by masking.

        What bare facets pass is multiplied by the quotient of what both pass at the nodes of
        `rules`: neither is less than zero, wherever they reflect totally.

        cosine: of the direction; None: the mean over diffuse light. bare: the mean without film.
        """
        film, edge, passes = self._film(si, active), eta, 1 - bare
        if self._total:  # index of a bare dielectric that reflects totally at the same facets
            edge = dr.select(film.eta < 1, dr.minimum(film.eta, eta), eta)
            more, less = (self._total.reflected(cosine, alpha, index) for index in (edge, eta))
            seen = self._mirror.reflected(cosine, alpha)
            passes -= (more - less) / dr.maximum(seen, _LEAST)
        filmed, unfilmed = mi.Spectrum(0), mi.Float(0)
        for c, weight in self.facets(cosine, alpha):
            filmed += weight * (1 - self._filmed(c, film, eta, si))
            unfilmed += weight * (1 - fresnel.dielectric(c, edge)[0])
        passes = dr.clip(passes * filmed / dr.maximum(unfilmed, _LEAST), 0, 1)
        return dr.lerp(mi.Spectrum(bare), 1 - passes, self._weight(si, active))

    def _filmed(self, cosine, film, eta, si):
        """Reflectance of a dielectric under the film, a spectrum."""

        def filmed(cosine, eta, wavelengths, *film):
            layer, below = thin_film.Film(*film), thin_film.Below(eta)
            responses = self._responses(wavelengths)
            values = [thin_film.reflectance(cosine, layer, below, x, DRJIT) for x in responses]
            return mi.Spectrum(*values)

        given = (mi.Float(x) for x in film)
        return compiled_once(filmed, mi.Float(cosine), mi.Float(eta), si.wavelengths, *given)

    def _weight(self, si, active):
        return self._inputs.at(si, active).thin_film_weight

    def _film(self, si, active):
        names = *_INDICES, "thin_film_thickness"
        ior, coat_ior, coat, thickness = self._inputs.at(si, active).of(*names)
        relative = dr.clip(formulas.relative_index(ior, coat_ior, coat, DRJIT), 1 / 3, 3)
        return thin_film.Film(relative, dr.maximum(ior, formulas.LEAST_INDEX), thickness)

    def _responses(self, wavelengths):
        if mi.is_monochromatic:
            return [thin_film.LUMINANCE]
        if mi.is_spectral:
            return [thin_film.wavelength_response(x) for x in wavelengths]
        return thin_film.RGB


@functools.cache
def rules() -> tuple[np.ndarray, np.ndarray]:
    """Gauss rules of GGX facets with Smith's masking at the nodes of `albedos`, float32.

    Returns:
        `NODES` cosines to facets and then their weights, whose sum is one:
        (ROUGHNESSES, COSINES, 2 NODES) of the facets seen from a direction, and
        (ROUGHNESSES, 2 NODES) of the facets met by diffuse light.
    """
    alphas, cosine = albedos.nodes()
    light = albedos.hemisphere_mean(np.eye(len(cosine)))[:, None]
    found = []
    for alpha in alphas:
        facets, weight = facets_seen(alpha, cosine)
        pairs = (facets, weight), (facets.ravel(), (weight * light).ravel())
        both = [
            gauss_rule(np.atleast_2d(x), np.atleast_2d(w / w.sum(-1, keepdims=True)), NODES)
            for x, w in pairs
        ]
        found.append([rule.swapaxes(1, 2).reshape(len(rule), -1) for rule in both])
    seen, mean = (np.stack(rows).astype(np.float32) for rows in zip(*found, strict=True))
    return seen, mean[:, 0]


def facets_seen(alpha: float, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines (D, M) to facets from directions of cosines (D,), and weights (D, M).

    The weights integrate a reflectance times f cos of a white lobe over the hemisphere. The facets
    lie evenly on the spherical cap of visible normals (Dupuy and Benyoub 2023).
    """
    nodes, shares = gauss(FINE)
    place = 0.5 * (nodes + 1)
    u = np.stack(np.meshgrid(0.5 * place, 1 - place, indexing="ij"), axis=-1)  # half of a turn
    facets = mirrored(in_plane(cosine[:, None]), alpha, u.reshape(-1, 2))
    return facets.cosine, 0.25 * np.outer(shares, shares).ravel() * facets.masking


def gauss_rule(x: np.ndarray, weights: np.ndarray, nodes: int) -> np.ndarray:
    """Nodes and weights (D, nodes, 2) of sums over points x (D, M), by the method of Lanczos."""
    total = weights.sum(axis=-1, keepdims=True)
    basis, previous, below = np.sqrt(weights / total), np.zeros_like(x), np.zeros_like(total)
    matrix = np.zeros((len(x), nodes, nodes))
    for k in range(nodes):
        matrix[:, k, k] = (x * basis * basis).sum(axis=-1)
        following = (x - matrix[:, k, k, None]) * basis - below * previous
        below = np.sqrt((following * following).sum(axis=-1, keepdims=True))
        previous, basis = basis, following / np.maximum(below, 1e-30)
        if k + 1 < nodes:
            matrix[:, k, k + 1] = matrix[:, k + 1, k] = below[:, 0]
    found, vectors = np.linalg.eigh(matrix)
    return np.stack([np.clip(found, 0.0, 1.0), total * vectors[:, 0] ** 2], axis=-1)
