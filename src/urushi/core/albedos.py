"""Directional albedos of rough interfaces, tabulated.

The interfaces scatter once: light that would hit a second facet is lost. These tables give the
loss, for which `energy_compensation` of coats and the plugin `openpbr` compensate.

The axes of the tables are the index, the root of the GGX width, and the cosine. Seen from the
denser side, an interface reflects totally at grazing angles. The edge moves with the index, and is
sharp for smooth interfaces. The axis of the cosine follows it, so that tables that are linear
between their nodes have it in its place.
"""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core import fresnel, microfacet
from urushi.core.namespace import NUMPY, Components, Namespace

#: Nodes of the tables: of the index below one and from one, of the width, and of the cosine.
BELOW, ABOVE, ROUGHNESSES, COSINES = 21, 25, 16, 48

#: Nodes of the index.
INDICES = BELOW + ABOVE

#: Cells of the axis of the cosine below the edge of total reflection.
TOTAL_CELLS = 24

#: Largest magnitude of the amplitude (eta - 1) / (eta + 1): an index of 3, or of 1/3.
LARGEST_AMPLITUDE = 0.5

#: Root of the amplitude's share at the last node below one. From there to an index of one, where
#: nothing is reflected, tables are constant relative to the edge.
_LEAST_ROOT = 0.03

#: Coordinate of the edge of total reflection.
_EDGE = TOTAL_CELLS / (COSINES - 1)

#: Least cosine of a node.
_LEAST_COSINE = 1e-5

#: Nodes of the quadrature over visible facets: of their azimuth, and of their height. Where some of
#: them reflect totally, the share that does decides, and the nodes are `FINE`.
AZIMUTHS, HEIGHTS = 20, 40
FINE = 28, 57


def indexnodes() -> np.ndarray:
    """The relative indices of the nodes (INDICES,), denser towards one."""
    below, above = np.linspace(-1, -_LEAST_ROOT, BELOW), np.linspace(0, 1, ABOVE)
    root = np.concatenate([below, above])
    amplitude = LARGEST_AMPLITUDE * np.abs(root) * root
    return (1 + amplitude) / (1 - amplitude)


def index_coordinate(eta: Any, xp: Namespace = NUMPY) -> Any:
    """Coordinate of an index in [0, 1]. None lies between the two nodes on either side of one."""
    amplitude = (eta - 1) / (eta + 1) / LARGEST_AMPLITUDE
    root = xp.sqrt(xp.absolute(amplitude))
    below = (BELOW - 1) * xp.clip((1 - root) / (1 - _LEAST_ROOT), 0, 1)
    above = BELOW + (ABOVE - 1) * root
    return xp.where(eta < 1, below, above) / (INDICES - 1)


def roughness_coordinate(alpha: Any, xp: Namespace = NUMPY) -> Any:
    """Where a GGX width lies among the nodes, in [0, 1]."""
    least = MIN_ALPHA**0.5
    return (xp.sqrt(alpha) - least) / (1 - least)


def cosine_coordinate(cosine: Any, eta: Any = None, xp: Namespace = NUMPY) -> Any:
    """Where a cosine lies among the nodes of an index, in [0, 1].

    It is the root of the cosine. For indices below one it is `_EDGE` at the cosine of total
    reflection, and above that linear in the root of the distance.

    eta: None in tables without index. A float is a constant.
    """
    root = xp.sqrt(xp.maximum(cosine, 0))
    constant = isinstance(eta, float)
    if eta is None or (constant and eta >= 1):
        return root
    edge = _edge(eta, xp)
    # Clipped where the derivatives have no bound.
    turn = xp.clip(1 - 2 * cosine / edge, -1 + 1e-6, 1 - 1e-6)
    total = (_EDGE / math.pi) * xp.arccos(turn)
    beyond = xp.maximum((cosine - edge) / (1 - edge), 1e-8)
    split = xp.where(cosine < edge, total, _EDGE + (1 - _EDGE) * xp.sqrt(beyond))
    return split if constant else xp.where(eta < 1, split, root)


def nodes(eta: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The GGX widths and, of an index, the cosines of the nodes."""
    roughness = np.linspace(MIN_ALPHA**0.5, 1, ROUGHNESSES)
    cosine, _ = _cosine_at(np.linspace(0, 1, COSINES), eta)
    return roughness**2, np.maximum(cosine, _LEAST_COSINE)


def hemisphere_mean(
    table: np.ndarray, etas: np.ndarray | None = None, *, entered: bool = False
) -> np.ndarray:
    """Mean of a table (..., COSINES) over diffuse light: 2 int_0^1 table(c) c dc.

    The tables are interpolated linearly between their nodes. The integral of this interpolation is
    exact, up to rounding, where the cosine is a polynomial of the coordinate.

    etas: None, or the indices (I,) of a table (I, ROUGHNESSES, COSINES).
    entered: only over directions that a smooth interface does not reflect totally.
    """
    values, weight = between_nodes(table, etas)
    if entered:
        assert etas is not None
        beyond = np.linspace(0, COSINES - 1, weight.shape[-1]) > TOTAL_CELLS
        weight = np.where((etas[:, None, None] < 1) & ~beyond, 0, weight)
        weight /= weight.sum(-1, keepdims=True)
    return (values * weight).sum(-1)


def between_nodes(
    table: np.ndarray, etas: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """A table (..., COSINES) at the points of a quadrature, (..., K), and their weights.

    The weights, (K,) or (I, 1, K), have a sum of one, as in `hemisphere_mean`. Multiply values of
    several tables before summing to get the mean of their product.
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    t, step = 0.5 * (points + 1), 1 / (COSINES - 1)
    x = ((np.arange(COSINES - 1)[:, None] + t) * step).ravel()
    values = table[..., :-1, None] * (1 - t) + table[..., 1:, None] * t
    given = [None] if etas is None else etas
    density = np.stack([np.prod(_cosine_at(x, eta), axis=0) for eta in given])
    weight = density * np.tile(weights, COSINES - 1)
    weight /= weight.sum(-1, keepdims=True)
    weight = weight[0] if etas is None else weight[:, None]
    return values.reshape(*table.shape[:-1], -1), weight


def _cosine_at(x: np.ndarray, eta: float | None) -> tuple[np.ndarray, np.ndarray]:
    """The inverse of `cosine_coordinate`, and its derivative."""
    if eta is None or eta >= 1:
        return x * x, 2 * x
    edge, total = float(_edge(eta, NUMPY)), x < _EDGE
    u, v = np.pi * np.minimum(x / _EDGE, 1), np.maximum(x - _EDGE, 0) / (1 - _EDGE)
    cosine = np.where(total, 0.5 * edge * (1 - np.cos(u)), edge + (1 - edge) * v * v)
    slope = np.where(
        total, 0.5 * np.pi * edge / _EDGE * np.sin(u), 2 * (1 - edge) / (1 - _EDGE) * v
    )
    return cosine, slope


def _edge(eta: Any, xp: Namespace) -> Any:
    """The cosine below which light meets total reflection, for an index from 1/3 to one."""
    eta = xp.maximum(eta, 1 / 3)
    return xp.sqrt(xp.maximum(1 - eta * eta, 1e-8))


class Tables(NamedTuple):
    """Albedos at the nodes, float32 (I, ROUGHNESSES, COSINES); their means have no cosine."""

    reflected: np.ndarray  # of the light from above, at the cosines of `nodes` of the index
    passed: np.ndarray
    reflected_mean: np.ndarray  # over diffuse light
    passed_mean: np.ndarray
    # Over diffuse light that has entered by a smooth interface of the same index, and that a mirror
    # returns.
    reflected_entered: np.ndarray
    passed_entered: np.ndarray
    inside: np.ndarray  # the mean cosine of the transmitted light; empty for two widths


@functools.cache
def tables(eta: float | None = None) -> Tables:
    """The tables of dielectric interfaces.

    eta: the only index, I is 1; None: all of `indexnodes`, which takes seconds the first time.
    """
    etas = indexnodes() if eta is None else np.array([eta])
    reflected, passed, inside = arrays = np.empty((3, len(etas), ROUGHNESSES, COSINES))
    facets: Facets | None = None
    for j, alpha in enumerate(nodes()[0]):
        for i, index in enumerate(etas):
            if index < 1 or i == 0 or etas[i - 1] < 1:  # indices from one share their cosines
                sizes = FINE if index < 1 else (AZIMUTHS, HEIGHTS)
                facets = visible_facets(alpha, nodes(float(index))[1], sizes=sizes)
            assert facets is not None
            arrays[:, i, j] = _albedos(facets, alpha, index)
    means = (
        hemisphere_mean(table, etas, entered=entered)
        for entered in (False, True)
        for table in (reflected, passed)
    )
    return Tables(*(x.astype(np.float32) for x in (reflected, passed, *means, inside)))


@functools.cache
def surface_loss(
    alpha: float, eta: float, mirrored: float = 0.0
) -> tuple[Callable[[np.ndarray], np.ndarray], float]:
    """The share of light that a coat's surface loses over a white base.

    mirrored: share of the base's light that it mirrors; the other is Lambertian.

    Returns:
        The share, a function of cosines (N,), and its cosine-weighted mean; 0 for an index of 1.
    """
    if eta == 1:
        return np.zeros_like, 0.0
    above, below = tables(eta), tables(1 / eta)
    place = roughness_coordinate(alpha) * (ROUGHNESSES - 1)
    first = min(int(place), ROUGHNESSES - 2)

    def at(table: np.ndarray) -> np.ndarray:
        return table[0, first] + (place - first) * (table[0, first + 1] - table[0, first])

    inside = leaving_share(below, mirrored, at)
    lost = np.clip(1 - at(above.reflected) - inside * at(above.passed), 0, 1)
    grid = np.linspace(0, 1, COSINES)
    mean = 1 - at(above.reflected_mean) - inside * at(above.passed_mean)
    return lambda cosine: np.interp(cosine_coordinate(cosine, eta), grid, lost), float(mean)


def leaving_share(
    below: Tables, mirrored: float, at: Callable[[np.ndarray], np.ndarray | float]
) -> np.ndarray | float:
    """Share of the light from a white base that leaves at last, over the mean that enters.

    below: seen from the base. at: the value of a table of means.
    """
    passed, reflected = (
        (1 - mirrored) * at(diffuse) + mirrored * at(entered)
        for diffuse, entered in (
            (below.passed_mean, below.passed_entered),
            (below.reflected_mean, below.reflected_entered),
        )
    )
    return passed / (1 - reflected)


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


class Facets(NamedTuple):
    """K facets that are seen from N directions."""

    seen: np.ndarray  # (N, 1) cosines of the directions
    cosine: np.ndarray  # (N, K) of facet and direction
    z: np.ndarray  # (N, K) of the facets' normals
    masking: np.ndarray  # (N, K) of the reflected directions
    weight: np.ndarray  # (K,) of the facets, of sum one


def visible_facets(
    alpha: float | Widths,
    cosine: np.ndarray,
    azimuth: float | None = None,
    sizes: tuple[int, int] = (AZIMUTHS, HEIGHTS),
) -> Facets:
    """The facets of a GGX surface seen from directions of given cosines (N,).

    azimuth: of the directions; None: 0, where one half of the facets mirrors the other and is left
        out. sizes: of `facet_nodes`.
    """
    turn, height, weight = facet_nodes(*sizes)
    turn, angle = (0.5 * turn, 0.0) if azimuth is None else (turn, azimuth)
    sine, cosine = np.sqrt(1 - cosine**2)[:, None], cosine[:, None]
    wi = Components(sine * np.cos(angle), sine * np.sin(angle), cosine)
    return Facets(cosine, *facets_at(wi, alpha, height, turn / (2 * np.pi)), weight)


def facets_at(
    wi: Components, alpha: Any, height: np.ndarray, turn: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cosines of wi and z of facet normals visible from wi, and the masking of reflected light.

    height, turn: in [0, 1], places of the facets on the spherical cap of visible normals, which
        has an equal density (Dupuy and Benyoub 2023). All arrays broadcast.
    """
    cap = microfacet.stretched(wi, alpha, NUMPY)
    m = microfacet.cap_normal(cap, alpha, height * (1 + cap.z) - cap.z, turn, NUMPY)
    m = NUMPY.normalized(m)
    facing = np.clip(wi.x * m.x + wi.y * m.y + wi.z * m.z, 0, 1)
    wo = Components(*(2 * facing * b - a for a, b in zip(wi, m, strict=True)))
    return facing, m.z, _masking(wo, alpha)


def _albedos(facets: Facets, alpha: float, eta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares (N,) of light reflected and passed by facets; mean cosine of the passed light."""
    with np.errstate(invalid="ignore", divide="ignore"):
        reflectance, cos_t = fresnel.dielectric(facets.cosine, eta, NUMPY)
    below = (facets.seen - facets.cosine * facets.z) / eta + cos_t * facets.z
    sine = np.sqrt(np.maximum(1 - below * below, 0))
    share = (1 - reflectance) * _masking(Components(sine, 0.0, below), alpha)
    passed = share @ facets.weight
    inside = ((share * below) @ facets.weight) / np.maximum(passed, 1e-12)
    return (reflectance * facets.masking) @ facets.weight, passed, inside


def _masking(w: Components, alpha: float | Widths) -> np.ndarray:
    """Smith masking of directions; zero below the horizon."""
    above = w._replace(z=np.maximum(w.z, 1e-9))
    return np.where(w.z > 0, microfacet.smith_g1(above, alpha, NUMPY), 0.0)
