"""Directional albedos of GGX reflectors, and of rough slabs below interfaces, tabulated.

The nodes are those of `core.albedos`. Albedos of two widths depend on the azimuth: on a brushed
surface, more light hits a second facet across the scratches than along them.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core.albedos import (
    between_nodes,
    hemisphere_mean,
    indexnodes,
    nodes,
    tables,
    visible_facets,
)
from urushi.openpbr_surface import eon

#: Nodes of the anisotropy (u - v) / (u + v) of the widths u >= v, and its greatest.
ANISOTROPIES, MOST = 8, 0.98

#: Terms of the cosine series in the azimuth, of 0, 2, 4 and 6 times it.
TERMS = 4

#: Azimuths from which the series is fitted.
_AZIMUTHS = np.linspace(0, np.pi / 2, 7)


class MirrorTables(NamedTuple):
    """Albedos of a reflector whose facets reflect all light, float32.

    Attributes:
        albedo: (ROUGHNESSES, COSINES); of two widths (ANISOTROPIES, ROUGHNESSES, COSINES, TERMS),
            the series in the azimuth, and the axis of the roughness is the mean of both widths.
        mean: (ROUGHNESSES,) or (ANISOTROPIES, ROUGHNESSES) its cosine-weighted mean.
    """

    albedo: np.ndarray
    mean: np.ndarray


@functools.cache
def mirror_tables() -> MirrorTables:
    """The tables of a GGX reflector without losses at its facets."""
    alphas, cosine = nodes()
    facets = [visible_facets(alpha, cosine) for alpha in alphas]
    albedo = np.stack([x.masking @ x.weight for x in facets])
    return MirrorTables(*(x.astype(np.float32) for x in (albedo, hemisphere_mean(albedo))))


@functools.cache
def anisotropic_tables() -> MirrorTables:
    """`mirror_tables` of two widths, which take some seconds the first time."""
    alphas, cosine = nodes()
    albedo = np.empty((ANISOTROPIES, len(alphas), len(cosine), TERMS))
    fit = np.linalg.pinv(np.cos(2 * np.outer(_AZIMUTHS, np.arange(TERMS))))
    for i, ratio in enumerate(np.linspace(0, MOST, ANISOTROPIES)):
        for j, alpha in enumerate(alphas):
            widths = Widths(alpha * (1 + ratio), alpha * (1 - ratio))
            facets = [visible_facets(widths, cosine, azimuth) for azimuth in _AZIMUTHS]
            albedo[i, j] = (fit @ np.stack([x.masking @ x.weight for x in facets])).T
    mean = hemisphere_mean(albedo[..., 0])
    return MirrorTables(albedo.astype(np.float32), mean.astype(np.float32))


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
