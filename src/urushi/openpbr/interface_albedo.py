"""Directional albedos of rough dielectric interfaces and of GGX reflectors, tabulated.

The interfaces scatter once: light that would hit a second facet is lost. These tables give the
loss, for which the plugin `openpbr` compensates.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from urushi.openpbr.albedo_axes import (
    COSINES,
    ROUGHNESSES,
    hemisphere_mean,
    indexnodes,
    nodes,
)

#: Nodes of the quadrature over visible facets: of their azimuth, and of their height. Where some of
#: them reflect totally, the share that does decides, and the nodes are `FINE`.
AZIMUTHS, HEIGHTS = 20, 40
FINE = 28, 57


class Tables(NamedTuple):
    """Albedos at the nodes, float32.

    Attributes:
        reflected, passed: (I, ROUGHNESSES, COSINES) of the light from above; the cosines are those
            of `albedo_axes.nodes` of the index.
        reflected_mean, passed_mean: (I, ROUGHNESSES) their cosine-weighted means.
        inside: (I, ROUGHNESSES, COSINES) mean cosine of the transmitted light.
    """

    reflected: np.ndarray
    passed: np.ndarray
    reflected_mean: np.ndarray
    passed_mean: np.ndarray
    inside: np.ndarray


class Facets(NamedTuple):
    """Facets that are seen from directions of given cosines (N,).

    Attributes:
        seen: (N, 1) the cosines. cosine: (N, K) of facet and direction.
        z: (N, K) of the facets' normals. masking: (N, K) of what they reflect.
        weight: (K,) of the facets, of sum one.
    """

    seen: np.ndarray
    cosine: np.ndarray
    z: np.ndarray
    masking: np.ndarray
    weight: np.ndarray


class MirrorTables(NamedTuple):
    """Albedos of a reflector whose facets reflect all light, float32.

    Attributes:
        albedo: (ROUGHNESSES, COSINES).
        mean: (ROUGHNESSES,) its cosine-weighted mean.
    """

    albedo: np.ndarray
    mean: np.ndarray


@functools.cache
def tables(eta: float | None = None) -> Tables:
    """The tables of dielectric interfaces.

    eta: the only index, I is 1; None: all of `albedo_axes.indexnodes`, which takes seconds the
        first time.
    """
    etas = indexnodes() if eta is None else np.array([eta])
    shape = len(etas), ROUGHNESSES, COSINES
    reflected, passed, inside = np.empty(shape), np.empty(shape), np.empty(shape)
    known: Facets | None = None
    for j, alpha in enumerate(nodes()[0]):
        for i, index in enumerate(etas):
            if index < 1 or i == 0 or etas[i - 1] < 1:  # indices from one share their cosines
                sizes = FINE if index < 1 else (AZIMUTHS, HEIGHTS)
                known = _facets(alpha, nodes(float(index))[1], sizes)
            assert known is not None
            reflected[i, j], passed[i, j], inside[i, j] = _albedos(known, alpha, index)
    means = (hemisphere_mean(table, etas) for table in (reflected, passed))
    arrays = reflected, passed, *means, inside
    return Tables(*(array.astype(np.float32) for array in arrays))


@functools.cache
def mirror_tables() -> MirrorTables:
    """The tables of a GGX reflector without losses at its facets."""
    alphas, cosine = nodes()
    albedo = np.empty((ROUGHNESSES, COSINES))
    for j, alpha in enumerate(alphas):
        known = _facets(alpha, cosine)
        albedo[j] = known.masking @ known.weight
    return MirrorTables(*(x.astype(np.float32) for x in (albedo, hemisphere_mean(albedo))))


@functools.cache
def facet_nodes(
    azimuths: int = AZIMUTHS, heights: int = HEIGHTS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Azimuths in [0, 2 pi) and heights in (0, 1) of the quadrature over visible facets (K,), and
    their weights (K,), of sum one.

    A height of zero is the steepest facet. The nodes are dense there, because the steep facets
    determine the loss: only few of them reflect light above the horizon. The azimuths are shifted
    from height to height, so that no step of the values lies between the same nodes of all heights.
    """
    row = np.repeat(np.arange(heights), azimuths)
    shift = (row * 0.6180339887498949 + 0.5) % 1
    turn = (np.tile(np.arange(azimuths), heights) + shift) * (2 * np.pi / azimuths)
    root = (row + 0.5) / heights
    return turn, root * root, root / root.sum()


def seen_facets(alpha: float, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facets of a GGX width from directions of given cosines (N,).

    Returns:
        Their cosines to the direction (N, K), and the shares (N, K) of its light that they would
        reflect out if they reflected all; their sum is the albedo of `mirror_tables`.
    """
    known = _facets(alpha, cosine)
    return known.cosine, known.masking * known.weight


def _facets(
    alpha: float, cosine: np.ndarray, sizes: tuple[int, int] = (AZIMUTHS, HEIGHTS)
) -> Facets:
    """The facets seen from directions of given cosines (N,); sizes: of `facet_nodes`.

    Those of half of the azimuths, which are the mirror images of the others.

    Source: Dupuy and Benyoub 2023, listing 1.
    """
    turn, height, weight = facet_nodes(*sizes)
    sine = np.sqrt(1 - cosine**2)[:, None]
    cosine = cosine[:, None]
    stretched = np.stack([alpha * sine, cosine])
    stretched = stretched / np.linalg.norm(stretched, axis=0)
    z = height * (1 + stretched[1]) - stretched[1]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    x = alpha * (across * np.cos(0.5 * turn) + stretched[0])
    y = alpha * across * np.sin(0.5 * turn)
    z = z + stretched[1]
    scale = 1 / np.sqrt(x * x + y * y + z * z)
    cos_m, z = np.clip((sine * x + cosine * z) * scale, 0, 1), z * scale
    return Facets(cosine, cos_m, z, _masking(2 * cos_m * z - cosine, alpha), weight)


def _albedos(facets: Facets, alpha: float, eta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What facets of an index reflect and pass, (N,), and the mean cosine below of the latter."""
    reflectance, cos_t = _fresnel(facets.cosine, eta)
    below = (facets.seen - facets.cosine * facets.z) / eta + cos_t * facets.z
    share = (1 - reflectance) * _masking(below, alpha)
    passed = share @ facets.weight
    inside = ((share * below) @ facets.weight) / np.maximum(passed, 1e-12)
    return (reflectance * facets.masking) @ facets.weight, passed, inside


def _masking(cosine: np.ndarray, alpha: float) -> np.ndarray:
    """Smith masking of GGX; zero below the horizon (Walter et al. 2007, equation 34)."""
    safe = np.maximum(cosine, 1e-9)
    tangent2 = (1 - safe * safe) / (safe * safe)
    g1 = 2 / (1 + np.sqrt(1 + alpha * alpha * tangent2))
    return np.where(cosine > 0, g1, 0.0)


def _fresnel(cosine: np.ndarray, eta: Any) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and refracted cosine, see `urushi.core.fresnel.dielectric`."""
    cos_t2 = 1 - (1 - cosine * cosine) / (eta * eta)
    cos_t = np.sqrt(np.maximum(cos_t2, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t)
        perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return np.where(cos_t2 > 0, reflectance, 1.0), cos_t
