"""Directional albedos of analytic lobes, for all widths and Fresnel terms.

With directions drawn by visible normals, the albedo is the mean of F(c) G1(wo), where c is the
cosine to the facet (Heitz and d'Eon 2014). For a width and an angle, c has a fixed distribution
with the weights G1(wo), which a Gauss rule of few nodes represents. The rules are tabulated, and
interpolated between widths.
"""

import functools
from typing import Any

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core import microfacet
from urushi.core.namespace import NUMPY, Components
from urushi.material.albedo_rule import AlbedoRule
from urushi.nets import lobe as lobes

#: Nodes of a Gauss rule, and for eta < 1, where the reflectance has an edge.
NODES, EDGE_NODES = 6, 16

#: Tabulated widths, evenly spaced in the root of alpha; and nodes in each dimension of the
#: quadrature by which the rules are made.
WIDTHS, FINE = 24, 40

#: Heights and azimuths of the quadrature for lobes of two widths, and lobes measured at once.
HEIGHTS, TURNS, ANISOTROPIC_BLOCK = 16, 20, 16


def lobe_albedos(lobe: np.ndarray, rule: AlbedoRule) -> np.ndarray:
    """Directional albedos (..., D) of lobes (..., 6) or (..., 7) at the directions of a rule.

    The error is below 0.001 mostly, up to 0.006 at cosines of a few times alpha, and for eta < 1 up
    to 0.15 at the critical angle of a sharp lobe. Lobes of two widths are measured at the rule's
    angles, and interpolated between.
    """
    rows = np.ascontiguousarray(lobe).reshape(-1, lobe.shape[-1])
    return _measured(rows, rule).reshape(*lobe.shape[:-1], len(rule.cosines))


def _measured(rows: np.ndarray, rule: AlbedoRule) -> np.ndarray:
    """Albedos float32 (N, D) of lobes (N, 6) or (N, 7)."""
    if len(rows) > 1 and (rows == rows[0]).all():  # as for the channels of a colourless coat
        return np.repeat(_measured(rows[:1], rule), len(rows), axis=0)
    if rows.shape[-1] == len(lobes.LOBE_NUMBERS):
        return isotropic_albedos(rows, rule.cosines)
    return rule.interpolated(anisotropic_albedos(rows, rule.wi[rule.first])).astype(np.float32)


def isotropic_albedos(lobe: np.ndarray, cosines: np.ndarray) -> np.ndarray:
    """Albedos float32 (..., D) of lobes (..., 6), each at all cosines (D,) of directions."""
    rows = lobe.reshape(-1, lobe.shape[-1])
    result = np.empty((len(rows), len(cosines)), np.float32)
    edge = (rows[:, 3] > 0) & (rows[:, 4] < 1)
    for place, nodes in ((~edge, NODES), (edge, EDGE_NODES)):
        if place.any():
            result[place] = _albedos(rows[place], cosines.tobytes(), nodes)
    return result.reshape(*lobe.shape[:-1], len(cosines))


def anisotropic_albedos(lobe: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """Albedos float32 (N, K) of lobes (N, 7) of two widths, at directions wi (K, 3).

    The mean of F(c) G1(wo) over points of the spherical cap of visible normals (Dupuy and Benyoub
    2023), with Gauss's nodes in height and evenly spaced azimuths.
    """
    result = np.empty((len(lobe), len(wi)), np.float32)
    nodes, shares = np.polynomial.legendre.leggauss(HEIGHTS)
    height = (0.5 * (nodes + 1)[:, None]).astype(np.float32)
    turn = ((np.arange(TURNS) + 0.5) / TURNS).astype(np.float32)
    weights = (0.5 * shares[:, None] / TURNS).astype(np.float32)
    directions = Components(*wi.T.astype(np.float32)[:, None, :, None, None])
    for start in range(0, len(lobe), ANISOTROPIC_BLOCK):
        part = slice(start, start + ANISOTROPIC_BLOCK)
        rows = lobe[part].astype(np.float32)[:, None, None, None]
        cosine, masking = _facets_at(directions, lobes.width(rows), height, turn)
        reflected = lobes.reflectance(rows, cosine)
        result[part] = (weights * masking * reflected).sum((-2, -1))
    return result


def _albedos(lobe: np.ndarray, cosines: bytes, nodes: int) -> np.ndarray:
    """Albedos (N, D) of lobes (N, 6) by the tabulated rules."""
    place = (np.sqrt(lobe[:, 0]) - MIN_ALPHA**0.5) / (1 - MIN_ALPHA**0.5) * (WIDTHS - 1)
    place = np.clip(place, 0.0, WIDTHS - 1)
    index = np.minimum(place.astype(np.intp), WIDTHS - 2)
    share = (place - index)[:, None, None, None].astype(np.float32)
    needed = tuple(sorted({*index.tolist(), *(index + 1).tolist()}))
    table, first = _rules(needed, cosines, nodes), np.searchsorted(needed, index)
    rule = (1 - share) * table[first] + share * table[first + 1]
    reflected = lobes.reflectance(lobe[:, None, None], rule[..., 0])
    return (reflected * rule[..., 1]).sum(axis=-1)


@functools.lru_cache(32)
def _rules(widths: tuple[int, ...], cosines: bytes, nodes: int) -> np.ndarray:
    """The rules (W, D, nodes, 2) of some widths. Each takes 10 ms: only those that are needed."""
    return np.stack([_rule_of_width(width, cosines, nodes) for width in widths])


@functools.cache
def _rule_of_width(width: int, cosines: bytes, nodes: int) -> np.ndarray:
    """A rule's cosines to the facet, and weights: float32 (D, nodes, 2)."""
    share = width / (WIDTHS - 1)
    alpha = (MIN_ALPHA**0.5 * (1 - share) + share) ** 2
    at = np.frombuffer(cosines)[:, None, None]
    return gauss_rule(*facets_seen(alpha, at), nodes).astype(np.float32)


def facets_seen(alpha: float, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosines (D, M) to facets, and weights (D, M) that integrate F(c) f cos over the hemisphere.

    cosine: (D, 1, 1) of the direction. The facets lie evenly on the spherical cap of visible
    normals (Dupuy and Benyoub 2023).
    """
    nodes, shares = np.polynomial.legendre.leggauss(FINE)
    place = 0.5 * (nodes + 1)
    wi = Components(np.sqrt(1 - cosine * cosine), 0.0, cosine)
    to_facet, masking = _facets_at(wi, alpha, place, 0.5 * place[:, None])  # half of a turn
    weight = 0.25 * shares[:, None] * shares * masking
    return to_facet.reshape(len(cosine), -1), weight.reshape(len(cosine), -1)


def _facets_at(
    wi: Components, alpha: Any, height: np.ndarray, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cosines of wi to facet normals visible from it, and the masking of reflected light.

    height, turn: in [0, 1], places of the facets on the cap, which has an equal density. All arrays
        broadcast.
    """
    cap = microfacet.stretched(wi, alpha, NUMPY)
    m = microfacet.cap_normal(cap, alpha, height * (1 + cap.z) - cap.z, turn, NUMPY)
    m = NUMPY.normalized(m)
    facing = np.clip(wi.x * m.x + wi.y * m.y + wi.z * m.z, 0, 1)
    x, y, z = (2 * facing * b - a for a, b in zip(wi, m, strict=True))
    masking = microfacet.smith_g1(Components(x, y, np.maximum(z, 1e-9)), alpha, NUMPY)
    return facing, np.where(z > 0, masking, 0.0)


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
