"""Tables of the statistical operators: mean Fresnel reflectance, share below the critical angle.

Belcour 2018 precomputes both. They are computed here at their first use, by 144 visible normals
a node, and are read by linear interpolation.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.physics import fresnel, microfacet
from urushi.physics.frame import reflect
from urushi.reference.monte_carlo import backend

COSINES, WIDTHS, SHARES = 48, 16, 32
#: Nodes of log(eta) below and above eta = 1; their distance is log(3) / ETAS_ABOVE.
ETAS_BELOW, ETAS_ABOVE = 16, 24
LOWEST_COSINE, LOWEST_INDEX = 1e-3, 1 / 3
#: Visible normals in one direction; a mean has their square. At a GGX width of 0.3, an index of 1.5
#: and an incident cosine of 0.3, 8 would miss a mean by 2 %, 12 by 0.3 %, against 20.
STRATA = 12


class Table(NamedTuple):
    """Values at the nodes of a regular grid over [0, 1]^3, float32."""

    values: np.ndarray

    def read(self, *places: Any) -> Any:
        """Interpolate at three Dr.Jit floats, which are clipped to [0, 1]."""
        float_type = type(places[0])
        index_type = dr.uint32_array_t(float_type)
        data = float_type(self.values.ravel())
        corners = [(index_type(0), float_type(1))]
        for place, size in zip(places, self.values.shape, strict=True):
            x = dr.clip(place, 0, 1) * (size - 1)
            low = dr.minimum(index_type(x), size - 2)
            t = x - float_type(low)
            corners = [
                (index * size + low + step, weight * (t if step else 1 - t))
                for index, weight in corners
                for step in (0, 1)
            ]
        return sum(weight * dr.gather(float_type, data, index) for index, weight in corners)


def mean_over_facets(term: Callable[[Any, Any], Any], cos_i: Any, alpha: Any) -> Any:
    """The mean of term(wo, cos_m) over a GGX mirror's reflected light, for light from cos_i.

    Args:
        term: function of the reflected direction and of the cosine on the facet.
        cos_i: cosine of the incident direction, in (0, 1].
        alpha: GGX width.

    The rule has STRATA^2 visible normals, weighed by the masking of wo.
    """
    vector = backend().Array3f
    wi = vector(dr.safe_sqrt(1 - cos_i * cos_i), 0, cos_i)
    total, norm = type(cos_i)(0), type(cos_i)(1e-12)
    for k in range(STRATA * STRATA):
        u1, u2 = (k // STRATA + 0.5) / STRATA, (k % STRATA + 0.5) / STRATA
        m = microfacet.sample_visible_normal(wi, alpha, u1, u2)
        wo = reflect(wi, m)
        weight = dr.select(wo.z > 0, microfacet.smith_g1(wo, alpha), 0)
        total += weight * term(wo, dr.dot(wi, m))
        norm += weight
    return total / norm


def mean_dielectric(cos_i: Any, alpha: Any, eta: Any) -> Any:
    """Mean Fresnel reflectance of a rough dielectric interface.

    The share of a GGX mirror's reflected light that the interface reflects: FGD over GD.

    Args:
        cos_i: cosine of the incident direction, in [0, 1].
        alpha: GGX width, in [0, 1].
        eta: relative index, in [0.52, 3] (clipped).
    """
    etas = ETAS_BELOW + ETAS_ABOVE
    place = (dr.log(eta) * (ETAS_ABOVE / np.log(3)) + ETAS_BELOW) / etas
    root = _root_mean_dielectric().read(dr.sqrt(cos_i), dr.sqrt(alpha), place)
    return root * root


def transmitted_share(cos_i: Any, alpha: Any, index: Any) -> Any:
    """Share of a GGX mirror's reflected light that is below the critical angle.

    The rest is totally reflected by an interface above, taken as smooth (Belcour 2018, TIR).

    Args:
        cos_i: cosine of the incident direction, in [0, 1].
        alpha: GGX width, in [0, 1].
        index: relative index of the medium above the interface; 1 where it is 1 or more.
    """
    place = (index - LOWEST_INDEX) / (1 - LOWEST_INDEX)
    share = _transmitted_share().read(dr.sqrt(cos_i), dr.sqrt(alpha), place)
    return dr.select(index < 1, share, 1)


@functools.cache
def _root_mean_dielectric() -> Table:
    """The root of the mean reflectance: it is almost linear in log(eta) on both sides of 1."""
    steps = np.arange(-ETAS_BELOW, ETAS_ABOVE + 1)
    etas = np.exp(steps * (np.log(3) / ETAS_ABOVE))

    def mean(cos_i, alpha, eta):
        def reflected(wo, cos_m):
            return fresnel.dielectric(dr.clip(cos_m, 0, 1), eta)[0]

        return dr.sqrt(mean_over_facets(reflected, cos_i, alpha))

    table = _tabulated(mean, etas)
    table.values[:, :, ETAS_BELOW] = 0  # no interface, where Fresnel's formula is 0 / 0
    return table


@functools.cache
def _transmitted_share() -> Table:
    def mean(cos_i, alpha, index):
        def passes(wo, cos_m):
            return dr.select(1 - wo.z * wo.z < index * index, 1.0, 0.0)

        return mean_over_facets(passes, cos_i, alpha)

    return _tabulated(mean, np.linspace(LOWEST_INDEX, 1, SHARES))


def _tabulated(function: Callable[[Any, Any, Any], Any], last: np.ndarray) -> Table:
    """Evaluate a function of cosine, width and a third quantity at all nodes."""
    cosines = np.maximum(np.linspace(0, 1, COSINES) ** 2, LOWEST_COSINE)
    widths = np.maximum(np.linspace(0, 1, WIDTHS) ** 2, LOWEST_COSINE)
    nodes = np.meshgrid(cosines, widths, last, indexing="ij")
    lanes = (backend().Float(node.ravel().astype(np.float32)) for node in nodes)
    return Table(np.array(function(*lanes).numpy(), np.float32).reshape(nodes[0].shape))
