"""Thin-film iridescence of OpenPBR's base (section 3.3): its Fresnel terms under a film.

The directional albedo of an interface is a mean, over visible facets, of the reflectance times
masking. The film's reflectance is known only during rendering. It is evaluated at the nodes of a
Gauss rule, which is exact for polynomials in the cosine to the facet. A film of an index below that
of the medium above it reflects totally at grazing angles, and the rule is over the other facets.
"""

import functools

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import albedos, anisotropic_albedos, fresnel
from urushi.core.namespace import DRJIT
from urushi.core.quadrature import gauss
from urushi.material.crossing import in_plane, mirrored
from urushi.mitsuba.recording import compiled_once
from urushi.mitsuba.tables import Interpolated
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

    def __init__(self, inputs: Inputs, transmits: bool = False):
        """transmits: whether `passing` is asked for light that leaves on the other side, too."""
        self._inputs = inputs
        indices = [inputs.known(name) for name in _INDICES]
        # Whether the film may reflect totally where the base does not.
        self._total = any(x is None for x in indices) or formulas.relative_index(*indices) < 1
        found = rules(self._total, visible=transmits and self._total)
        self._rule, self._mean_rule = map(Interpolated, found)

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

    def passing(self, bare, cosine, alpha, index, si, active, *, above=True):
        """What filmed facets pass, a spectrum, where bare ones pass `bare`.

        Both are proportional to the mean of one minus the reflectance of the facets, at the nodes
        of `rules`.

        cosine: of the direction; None: the mean over diffuse light. index: of the base relative to
        the medium above it. above: whether the light is above.
        """
        film = self._film(si, active)
        eta = dr.select(above, index, 1 / index)
        near = dr.select(above, film.eta, film.eta / index)
        edge = dr.select(near < 1, dr.minimum(near, eta), eta)  # of total reflection under the film
        facets = bare_facets = self._facets(cosine, alpha, edge)
        if self._total:
            bare_facets = self._facets(cosine, alpha, eta)
        filmed, unfilmed = mi.Spectrum(0), mi.Float(0)
        for c, weight in facets:
            outside = dr.select(above, c, dr.maximum(fresnel.dielectric(c, eta)[1], 0))
            filmed += weight * (1 - self._filmed(outside, film, index, si))
        for c, weight in bare_facets:
            unfilmed += weight * (1 - fresnel.dielectric(c, eta)[0])
        passed = bare * (filmed / dr.maximum(unfilmed, _LEAST))
        return dr.lerp(mi.Spectrum(bare), passed, self._weight(si, active))

    def _facets(self, cosine, alpha, eta):
        """Cosines and weights of a rule of `rules`, without facets that reflect totally at eta."""
        at = [albedos.roughness_coordinate(alpha, DRJIT)]
        if cosine is not None:
            at.insert(0, albedos.cosine_coordinate(cosine, eta if self._total else None, DRJIT))
        if self._total:
            at.append(anisotropic_albedos.index_coordinate(dr.clip(eta, 1 / 3, 3), DRJIT))
        found = (self._mean_rule if cosine is None else self._rule)(at)
        return list(zip(found[:NODES], found[NODES:], strict=True))

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
def rules(total: bool, visible: bool) -> tuple[np.ndarray, np.ndarray]:
    """Gauss rules of GGX facets at the nodes of `albedos`, float32.

    total: whether there is an axis of the index, at the nodes I of `anisotropic_albedos`: the rules
        are then over the facets that do not reflect totally. visible: whether facets have the
        weight by which they are seen; else this is multiplied by Smith's masking of the light that
        they reflect.

    Returns:
        `NODES` cosines to facets and then their weights, whose sum is one over all facets:
        (I, ROUGHNESSES, COSINES, 2 NODES) of the facets seen from a direction, and
        (I, ROUGHNESSES, 2 NODES) of the facets met by diffuse light; without I if not total.
    """
    etas = np.minimum(anisotropic_albedos.indexnodes(), 1) if total else [1.0]
    found = zip(*(_rules_of_index(float(eta), visible) for eta in etas), strict=True)
    seen, mean = map(np.stack, found)
    return (seen, mean) if total else (seen[0], mean[0])


@functools.cache
def _rules_of_index(eta: float, visible: bool) -> tuple[np.ndarray, np.ndarray]:
    """`rules` of facets that do not reflect totally at an index up to one."""
    alphas, cosine = albedos.nodes(eta)
    edge = (1 - eta * eta) ** 0.5
    light = albedos.hemisphere_mean(np.eye(len(cosine))[None], np.array([eta]))[0, :, None]
    found = []
    for alpha in alphas:
        facets, weight = facets_seen(alpha, cosine, visible)
        both = []
        for x, w in ((facets, weight), (facets.reshape(1, -1), (weight * light).reshape(1, -1))):
            w = np.where(x > edge, 1, 1e-9) * (w / w.sum(-1, keepdims=True))
            rule = gauss_rule(x, w, NODES).swapaxes(1, 2)
            rule[:, 0] = np.maximum(rule[:, 0], edge)  # where there is hardly any such facet
            both.append(rule.reshape(len(x), -1))
        found.append(both)
    seen, mean = (np.stack(rows).astype(np.float32) for rows in zip(*found, strict=True))
    return seen, mean[:, 0]


def facets_seen(alpha: float, cosine: np.ndarray, visible: bool) -> tuple[np.ndarray, np.ndarray]:
    """Cosines (D, M) to facets from directions of cosines (D,), and weights (D, M).

    The weights integrate a reflectance times f cos of a white lobe over the hemisphere, or over all
    directions if visible. The facets lie evenly on the spherical cap of visible normals (Dupuy and
    Benyoub 2023).
    """
    nodes, shares = gauss(FINE)
    place = 0.5 * (nodes + 1)
    u = np.stack(np.meshgrid(0.5 * place, 1 - place, indexing="ij"), axis=-1)  # half of a turn
    facets = mirrored(in_plane(cosine[:, None]), alpha, u.reshape(-1, 2))
    masking = np.ones_like(facets.masking) if visible else facets.masking
    return facets.cosine, 0.25 * np.outer(shares, shares).ravel() * masking


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
