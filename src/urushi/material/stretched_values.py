"""f of codes of two GGX widths at many pairs of directions, as one Dr.Jit kernel.

`Networks.f` computes all functions of the basis at each pair. Here the tables of the functions are
contracted with the codes first, and a kernel looks up the results.
"""

import functools
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core import lanes, microfacet
from urushi.core.lanes import Lane
from urushi.core.namespace import DRJIT
from urushi.core.stretched import stretched
from urushi.core.table import MAX_LOG, MIN_LOG
from urushi.material import adding
from urushi.material.material import Material
from urushi.nets import lobe as lobes


def of_material(material: Material) -> adding.Brdf:
    """f of a material of two widths, without rotation, as a function; see `Material.f`."""
    z, size = material.latents, material.model.arch.lobe
    table = material.model.networks.table(z)
    return functools.partial(f_of, z[:, :size], table=table, log_stretch=z[:, -1])


def f_of(
    lobe: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    *,
    table: np.ndarray | None = None,
    log_stretch: np.ndarray | None = None,
) -> np.ndarray:
    """f float32 (N, C) [1/sr] of lobes (C, 7) and rests at float32 pairs (N, 3).

    table, log_stretch: of the rests, see `Networks.table` (*`SHAPE`, C, 1 + `FACTORS`), and ln s
        (C,); None without rests.
    """
    terms = () if table is None else np.moveaxis(table, (-2, -1), (1, 0))

    def value(lane: Lane) -> Any:
        a, b = lane.directions()
        both, along, *fresnel, across = a + b, *(lane.number(x) for x in lobe.T)
        reflectance = lobes.reflectance_of(fresnel, microfacet.facet_cosine(both, DRJIT), DRJIT)
        f = microfacet.lobe_shape(Widths(along, across), a, b, both, DRJIT) * reflectance
        if log_stretch is not None and len(terms):
            stretch2 = lane.number(np.exp(2 * log_stretch))
            places, around = stretched(both, a - b, stretch2, DRJIT)
            logs = [lane.table(term)(places) for term in terms]
            log = sum((x * y for x, y in zip(logs[1:], around, strict=True)), logs[0])
            f = f + DRJIT.exp(DRJIT.clip(log, MIN_LOG, MAX_LOG))
        return DRJIT.where((a.z > 0) & (b.z > 0), f, 0)

    return lanes.sums(value, len(lobe), (wi, wo), 1)
