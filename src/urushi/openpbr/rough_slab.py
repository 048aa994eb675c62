"""First reflection by a rough white slab below a dielectric interface: the fraction that leaves.

Light from a direction is transmitted by the interface's facets, and is then assumed to have their
mean cosine in the slab. Of its first reflection by a Lambertian slab, the interface transmits the
fraction passed_mean / eta^2, whatever the direction. EON reflects more or less towards directions
that the interface transmits. The deviation is proportional to `eon.deviation`, so that one table
serves all roughnesses of the slab.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.core import eon
from urushi.openpbr import albedo_axes, interface_albedo


class Tables(NamedTuple):
    """Values at the nodes of `interface_albedo`, float32, for a base_diffuse_roughness of one.

    Attributes:
        inside: (I, ROUGHNESSES, COSINES) mean cosine in the slab.
        excess: the same shape; ratio of the leaving light to that of a Lambertian slab, minus one.
        excess_mean: (I, ROUGHNESSES) its mean over the transmitted part of diffuse light.
    """

    inside: np.ndarray
    excess: np.ndarray
    excess_mean: np.ndarray


@functools.cache
def tables(eta: float | None = None) -> Tables:
    """The tables of a white slab.

    eta: the only index, I is 1; None: all of `albedo_axes.indexnodes`.
    """
    known = interface_albedo.tables(eta)
    etas = albedo_axes.indexnodes() if eta is None else np.array([eta])
    inside = np.clip(known.inside.astype(np.float64), 0, 1)
    passed, weight = albedo_axes.between_nodes(1 - known.reflected.astype(np.float64), etas)
    weights = passed * weight
    weights /= weights.sum(-1, keepdims=True)
    away, _ = albedo_axes.between_nodes(inside)
    single = np.empty_like(inside)
    for k in range(inside.shape[-1]):
        along = eon.single_over_azimuths(inside[..., k, None], away, 1.0)
        single[..., k] = (weights * along).sum(-1)
    lost = 1 - eon.single_albedo(inside, 1.0)
    lost_mean = (weights * (1 - eon.single_albedo(away, 1.0))).sum(-1, keepdims=True)
    excess = single + lost * lost_mean / (1 - eon.single_mean(1.0)) - 1
    mean = (weights * albedo_axes.between_nodes(excess)[0]).sum(-1)
    return Tables(*(x.astype(np.float32) for x in (inside, excess, mean)))
