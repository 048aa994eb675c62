"""Directional albedos of rough interfaces, of GGX reflectors and of slabs below them, tabulated.

The interfaces scatter once: light that would hit a second facet is lost. These tables give the
loss, for which the plugin `openpbr` compensates. Albedos of two widths depend on the azimuth: on a
brushed surface, more light hits a second facet across the scratches than along them.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.core import eon
from urushi.openpbr_surface.albedo_axes import (
    COSINES,
    ROUGHNESSES,
    between_nodes,
    hemisphere_mean,
    indexnodes,
    nodes,
)

#: Nodes of the quadrature over visible facets: of their azimuth, and of their height. Where some of
#: them reflect totally, the share that does decides, and the nodes are `FINE`.
AZIMUTHS, HEIGHTS = 20, 40
FINE = 28, 57

#: Nodes of the anisotropy (u - v) / (u + v) of the widths u >= v, and its greatest.
ANISOTROPIES, MOST = 8, 0.98

#: Terms of the cosine series in the azimuth, of 0, 2, 4 and 6 times it.
TERMS = 4

#: Azimuths from which the series is fitted.
_AZIMUTHS = np.linspace(0, np.pi / 2, 7)


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
    reflectance, cos_t = fresnel(facets.cosine, eta)
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


def fresnel(cosine: np.ndarray, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and refracted cosine, see `urushi.core.fresnel.dielectric`."""
    cos_t2 = 1 - (1 - cosine * cosine) / (eta * eta)
    cos_t = np.sqrt(np.maximum(cos_t2, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t)
        perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return np.where(cos_t2 > 0, reflectance, 1.0), cos_t


class AnisotropicTables(NamedTuple):
    """Albedos of a reflector whose facets reflect all light, float32.

    Attributes:
        albedo: (ANISOTROPIES, ROUGHNESSES, COSINES, TERMS), the series in the azimuth.
        mean: (ANISOTROPIES, ROUGHNESSES) the cosine-weighted mean over the hemisphere.

    The roughness axis is the mean of both widths.
    """

    albedo: np.ndarray
    mean: np.ndarray


@functools.cache
def anisotropic_tables() -> AnisotropicTables:
    """The tables, which take some seconds the first time."""
    alphas, cosine = nodes()
    albedo = np.empty((ANISOTROPIES, len(alphas), len(cosine), TERMS))
    series = np.cos(2 * np.outer(_AZIMUTHS, np.arange(TERMS)))
    fit = np.linalg.pinv(series)
    for i, ratio in enumerate(np.linspace(0, MOST, ANISOTROPIES)):
        for j, alpha in enumerate(alphas):
            widths = alpha * (1 + ratio), alpha * (1 - ratio)
            values = [_azimuthal_albedo(widths, cosine, azimuth) for azimuth in _AZIMUTHS]
            albedo[i, j] = (fit @ np.stack(values)).T
    mean = hemisphere_mean(albedo[..., 0])
    return AnisotropicTables(albedo.astype(np.float32), mean.astype(np.float32))


def _azimuthal_albedo(
    widths: tuple[float, float], cosine: np.ndarray, azimuth: float
) -> np.ndarray:
    """Share (N,) of the light from directions of given cosines (N,) that leaves at once.

    A quadrature over visible facets. Source: Dupuy and Benyoub 2023, listing 1.
    """
    (u, v), (turn, height, weight) = widths, facet_nodes()
    sine = np.sqrt(1 - cosine**2)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])[..., None]
    stretched = wi * np.array([u, v, 1.0])[:, None, None]
    stretched = stretched / np.linalg.norm(stretched, axis=0)
    z = height * (1 + stretched[2]) - stretched[2]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    x = u * (across * np.cos(turn) + stretched[0])
    y = v * (across * np.sin(turn) + stretched[1])
    m = np.stack([x, y, z + stretched[2]])
    m = m / np.linalg.norm(m, axis=0)
    wo = 2 * np.clip((wi * m).sum(axis=0), 0, 1) * m - wi
    slope2 = ((u * wo[0]) ** 2 + (v * wo[1]) ** 2) / np.maximum(wo[2], 1e-9) ** 2
    masking = np.where(wo[2] > 0, 2 / (1 + np.sqrt(1 + slope2)), 0.0)
    return masking @ weight


# The first reflection by a rough white slab below an interface. The facets pass light from a
# direction, which is then assumed to have their mean cosine in the slab. Of its first reflection by
# a Lambertian slab, the interface passes the share passed_mean / eta^2, whatever the direction. EON
# reflects more or less towards directions that the interface passes. The deviation is proportional
# to `eon.deviation`, so that one table serves all roughnesses of the slab.


class SlabTables(NamedTuple):
    """A rough white slab below an interface, float32, for a base_diffuse_roughness of one.

    Attributes:
        inside: (I, ROUGHNESSES, COSINES) mean cosine in the slab.
        excess: the same shape; light that leaves over what leaves a Lambertian slab, minus one.
        excess_mean: (I, ROUGHNESSES) its mean over the transmitted part of diffuse light.
    """

    inside: np.ndarray
    excess: np.ndarray
    excess_mean: np.ndarray


@functools.cache
def slab_tables(eta: float | None = None) -> SlabTables:
    """The tables of a white slab.

    eta: the only index, I is 1; None: all of `indexnodes`.
    """
    known = tables(eta)
    etas = indexnodes() if eta is None else np.array([eta])
    inside = np.clip(known.inside.astype(np.float64), 0, 1)
    passed, weight = between_nodes(1 - known.reflected.astype(np.float64), etas)
    weights = passed * weight
    weights /= weights.sum(-1, keepdims=True)
    away, _ = between_nodes(inside)
    single = np.empty_like(inside)
    for k in range(inside.shape[-1]):
        along = eon.single_over_azimuths(inside[..., k, None], away, 1.0)
        single[..., k] = (weights * along).sum(-1)
    lost = 1 - eon.single_albedo(inside, 1.0)
    lost_mean = (weights * (1 - eon.single_albedo(away, 1.0))).sum(-1, keepdims=True)
    excess = single + lost * lost_mean / (1 - eon.single_mean(1.0)) - 1
    mean = (weights * between_nodes(excess)[0]).sum(-1)
    return SlabTables(*(x.astype(np.float32) for x in (inside, excess, mean)))
