"""Directional albedos of rough dielectric interfaces and of GGX reflectors, tabulated.

The interfaces scatter once: light that would hit a second facet is lost. These tables give the
loss, for which the plugin `openpbr` compensates.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA

#: Nodes of the tables: of the index, of the root of the GGX width, and of the root of the cosine.
INDICES, ROUGHNESSES, COSINES = 49, 16, 32

#: Largest magnitude of the amplitude (eta - 1) / (eta + 1): an index of 3, or of 1/3.
LARGEST_AMPLITUDE = 0.5

#: Nodes of the quadrature over visible facets: of their azimuth, and of their height.
AZIMUTHS, HEIGHTS = 20, 40


class Tables(NamedTuple):
    """Albedos at the nodes, float32.

    Attributes:
        reflected, passed: (I, ROUGHNESSES, COSINES) of the light from above.
        reflected_mean, passed_mean: (I, ROUGHNESSES) their cosine-weighted means.
        inside: (I, ROUGHNESSES, COSINES) mean cosine of the transmitted light.
    """

    reflected: np.ndarray
    passed: np.ndarray
    reflected_mean: np.ndarray
    passed_mean: np.ndarray
    inside: np.ndarray


class MirrorTables(NamedTuple):
    """Albedos of a reflector whose facets reflect all light, float32.

    Attributes:
        albedo: (ROUGHNESSES, COSINES).
        mean: (ROUGHNESSES,) its cosine-weighted mean.
    """

    albedo: np.ndarray
    mean: np.ndarray


def indexnodes() -> np.ndarray:
    """The relative indices of the nodes, denser towards one, where total reflection sets in."""
    root = np.linspace(-1, 1, INDICES)
    amplitude = LARGEST_AMPLITUDE * np.abs(root) * root
    return (1 + amplitude) / (1 - amplitude)


def index_coordinate(eta: Any, xp: Any = np) -> Any:
    """Where an index lies among the nodes, in [0, 1]."""
    amplitude = (eta - 1) / (eta + 1) / LARGEST_AMPLITUDE
    root = xp.sqrt(xp.abs(amplitude))
    return 0.5 + 0.5 * (root * xp.sign(amplitude))


def roughness_coordinate(alpha: Any, xp: Any = np) -> Any:
    """Where a GGX width lies among the nodes, in [0, 1]."""
    least = MIN_ALPHA**0.5
    return (xp.sqrt(alpha) - least) / (1 - least)


@functools.cache
def tables(eta: float | None = None) -> Tables:
    """The tables of dielectric interfaces.

    eta: the only index, I is 1; None: all of `index_nodes`, which takes seconds the first time.
    """
    alphas, cosine = nodes()
    etas = indexnodes() if eta is None else np.array([eta])
    reflected = np.empty((len(etas), ROUGHNESSES, COSINES))
    passed, inside = np.empty_like(reflected), np.empty_like(reflected)
    for j, alpha in enumerate(alphas):
        wi, m, cos_m = _visible_facets(alpha, cosine)
        masking = _masking(2 * cos_m * m[..., 2] - wi[2], alpha)
        for i, index in enumerate(etas):
            reflectance, cos_t = _fresnel(cos_m, index)
            reflected[i, j] = facet_mean(reflectance * masking)
            below = (wi[2] - cos_m * m[..., 2]) / index + cos_t * m[..., 2]
            share = (1 - reflectance) * _masking(below, alpha)
            passed[i, j] = facet_mean(share)
            inside[i, j] = facet_mean(share * below) / np.maximum(passed[i, j], 1e-12)
    means = (hemisphere_mean(table) for table in (reflected, passed))
    arrays = reflected, passed, *means, inside
    return Tables(*(array.astype(np.float32) for array in arrays))


@functools.cache
def mirror_tables() -> MirrorTables:
    """The tables of a GGX reflector without losses at its facets."""
    alphas, cosine = nodes()
    albedo = np.empty((ROUGHNESSES, COSINES))
    for j, alpha in enumerate(alphas):
        wi, m, cos_m = _visible_facets(alpha, cosine)
        albedo[j] = facet_mean(_masking(2 * cos_m * m[..., 2] - wi[2], alpha))
    return MirrorTables(*(x.astype(np.float32) for x in (albedo, hemisphere_mean(albedo))))


def nodes() -> tuple[np.ndarray, np.ndarray]:
    """The GGX widths and cosines of the nodes."""
    roughness = np.linspace(MIN_ALPHA**0.5, 1, ROUGHNESSES)
    return roughness**2, np.maximum(np.linspace(0, 1, COSINES) ** 2, 1e-5)


def hemisphere_mean(table: np.ndarray) -> np.ndarray:
    """2 times the integral of a table (..., COSINES) times the cosine over [0, 1].

    Exact for tables that are linear in the root between the nodes, as they are interpolated.
    """
    values, weight = between_nodes(table)
    return values @ weight


def between_nodes(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A table (..., COSINES) at the points of a quadrature, (..., K), and their weights (K,).

    The weights are those of `hemisphere_mean`, of sum one. The mean of a product of tables is that
    of the product of their values here.
    """
    root = np.linspace(0, 1, table.shape[-1])
    points, weights = np.polynomial.legendre.leggauss(4)
    t = 0.5 * (points + 1)
    x = (root[:-1, None] + t * root[1]).ravel()
    values = table[..., :-1, None] * (1 - t) + table[..., 1:, None] * t
    weight = 2 * root[1] * np.tile(weights, len(root) - 1) * x**3
    return values.reshape(*table.shape[:-1], -1), weight


@functools.cache
def facet_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Azimuths [rad] and heights in (0, 1) of the quadrature over visible facets (K,).

    A height of zero is the steepest facet. The nodes are dense there, because the steep facets
    determine the loss: only few of them reflect light above the horizon.
    """
    turn = (np.arange(AZIMUTHS) + 0.5) * (2 * np.pi / AZIMUTHS)
    root = (np.arange(HEIGHTS) + 0.5) / HEIGHTS
    turns, heights = np.meshgrid(turn, root**3)
    return turns.ravel(), heights.ravel()


def facet_mean(values: np.ndarray) -> np.ndarray:
    """The mean over visible facets of values (..., K) at `facet_nodes`."""
    weight = facet_nodes()[1] ** (2 / 3)  # of the root, whose cube the height is
    return values @ (weight / weight.sum())


def seen_facets(alpha: float, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Facets of a GGX width from directions of given cosines (N,).

    Returns:
        Their cosines to the direction (N, K), and the shares (N, K) of its light that they would
        reflect out if they reflected all; their sum is the albedo of `mirror_tables`.
    """
    wi, m, cos_m = _visible_facets(alpha, cosine)
    weight = facet_nodes()[1] ** (2 / 3)
    return cos_m, _masking(2 * cos_m * m[..., 2] - wi[2], alpha) * (weight / weight.sum())


def _visible_facets(alpha: float, cosine: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Facets seen from directions of given cosines, at `facet_nodes`: wi, m (N, K, 3), wi.m.

    wi is (3, N, 1). Source: Dupuy and Benyoub 2023, listing 1.
    """
    turn, height = facet_nodes()
    sine = np.sqrt(1 - cosine**2)[:, None]
    wi = np.stack([sine, np.zeros_like(sine), cosine[:, None]])
    stretched = np.stack([alpha * wi[0], wi[2]])
    stretched = stretched / np.linalg.norm(stretched, axis=0)
    z = height * (1 + stretched[1]) - stretched[1]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    x = alpha * (across * np.cos(turn) + stretched[0])
    y = alpha * across * np.sin(turn)
    m = np.stack([x, y, z + stretched[1]], axis=-1)
    m = m / np.linalg.norm(m, axis=-1, keepdims=True)
    return wi, m, np.clip(wi[0] * m[..., 0] + wi[2] * m[..., 2], 0, 1)


def _masking(cosine: np.ndarray, alpha: float) -> np.ndarray:
    """Smith masking of GGX; zero below the horizon (Walter et al. 2007, equation 34)."""
    safe = np.maximum(cosine, 1e-9)
    tangent2 = (1 - safe * safe) / (safe * safe)
    g1 = 2 / (1 + np.sqrt(1 + alpha * alpha * tangent2))
    return np.where(cosine > 0, g1, 0.0)


def _fresnel(cosine: np.ndarray, eta: Any) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and refracted cosine, see `urushi.physics.fresnel.dielectric`."""
    cos_t2 = 1 - (1 - cosine * cosine) / (eta * eta)
    cos_t = np.sqrt(np.maximum(cos_t2, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t)
        perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return np.where(cos_t2 > 0, reflectance, 1.0), cos_t
