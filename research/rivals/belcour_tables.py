"""Tables of the statistical operators: mean Fresnel reflectance, share below the critical angle.

Belcour 2018 precomputes both. Here they are computed at their first use, by 144 visible normals per
node, and interpolated linearly.
"""

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect
from urushi.walk.monte_carlo import backend

COSINES, WIDTHS, SHARES = 48, 16, 32
#: Nodes of log(eta) below and above eta = 1; their distance is log(3) / ETAS_ABOVE.
ETAS_BELOW, ETAS_ABOVE = 16, 24
LOWEST_COSINE, LOWEST_INDEX = 1e-3, 1 / 3
#: Cosines on the facet at which a function of it is known, for its mean (`facet_weights`): squares
#: of Chebyshev's points, because Fresnel's term of a metal is steep near grazing.
FACET_COSINES = tuple((0.5 - 0.5 * math.cos(math.pi * k / 8)) ** 2 for k in range(9))
#: Visible normals in one direction; a mean has their square. At a GGX width of 0.3, an index of 1.5
#: and an incident cosine of 0.3, 8 would miss a mean by 2 %, 12 by 0.3 %, against 20.
STRATA = 12


class Table(NamedTuple):
    """Values at the nodes of a regular grid over [0, 1]^3, float32."""

    values: np.ndarray

    def read(self, *places: Any, data: Any = None) -> Any:
        """Interpolate at three Dr.Jit floats, which are clipped to [0, 1].

        data: the values as such floats; None: they are copied to them.
        """
        return self._read(places, self.values.shape, data)

    def read_all(self, *places: Any, data: Any = None) -> list[Any]:
        """Interpolate all values along the last axis, at two Dr.Jit floats."""
        *shape, last = self.values.shape
        return [self._read(places, shape, data, last, k) for k in range(last)]

    def _read(self, places: Any, shape: Any, data: Any, stride: int = 1, offset: int = 0) -> Any:
        float_type = type(places[0])
        index_type = dr.uint32_array_t(float_type)
        if data is None:
            data = float_type(self.values.ravel())
        corners = [(index_type(0), float_type(1))]
        for place, size in zip(places, shape, strict=True):
            x = dr.clip(place, 0, 1) * (size - 1)
            low = dr.minimum(index_type(x), size - 2)
            t = x - float_type(low)
            corners = [
                (index * size + low + step, weight * (t if step else 1 - t))
                for index, weight in corners
                for step in (0, 1)
            ]
        return sum(
            weight * dr.gather(float_type, data, index * stride + offset)
            for index, weight in corners
        )


class Data(NamedTuple):
    """The values of the tables, flat, as Dr.Jit floats of one type."""

    root_mean_dielectric: Any
    transmitted_share: Any
    facet_weights: Any = None


def data(float_type: type, *, with_facets: bool = False) -> Data:
    """The tables' values as Dr.Jit floats; `facet_weights` only if `with_facets`."""
    found = [_root_mean_dielectric(), _transmitted_share()]
    if with_facets:
        found.append(_facet_weights())
    return Data(*(float_type(table.values.ravel()) for table in found))


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


def mean_dielectric(cos_i: Any, alpha: Any, eta: Any, data: Data | None = None) -> Any:
    """Mean Fresnel reflectance of a rough dielectric interface.

    The share of a GGX mirror's reflected light that the interface reflects: FGD over GD.

    Args:
        cos_i: cosine of the incident direction, in [0, 1].
        alpha: GGX width, in [0, 1].
        eta: relative index, in [0.52, 3] (clipped).
        data: the tables' values as arrays of the type of cos_i; None: they are copied to it.
    """
    etas = ETAS_BELOW + ETAS_ABOVE
    place = (dr.log(eta) * (ETAS_ABOVE / np.log(3)) + ETAS_BELOW) / etas
    values = None if data is None else data.root_mean_dielectric
    root = _root_mean_dielectric().read(dr.sqrt(cos_i), dr.sqrt(alpha), place, data=values)
    return root * root


def transmitted_share(cos_i: Any, alpha: Any, index: Any, data: Data | None = None) -> Any:
    """Share of a GGX mirror's reflected light that is below the critical angle.

    The rest is totally reflected by an interface above, taken as smooth (Belcour 2018, TIR).

    Args:
        cos_i: cosine of the incident direction, in [0, 1].
        alpha: GGX width, in [0, 1].
        index: relative index of the medium above the interface; 1 where it is 1 or more.
        data: as of `mean_dielectric`.
    """
    place = (index - LOWEST_INDEX) / (1 - LOWEST_INDEX)
    values = None if data is None else data.transmitted_share
    share = _transmitted_share().read(dr.sqrt(cos_i), dr.sqrt(alpha), place, data=values)
    return dr.select(index < 1, share, 1)


def mean_of_values(values: Sequence[Any], cos_i: Any, alpha: Any, data: Data | None = None) -> Any:
    """`mean_over_facets` of a function of the facet's cosine, by its values at `FACET_COSINES`.

    The function is taken as the polynomial in the cosine's root through these values, whose mean is
    a sum with tabulated weights.

    Args:
        values: Dr.Jit floats at `FACET_COSINES`.
        cos_i: cosine of the incident direction, in [0, 1].
        alpha: GGX width, in [0, 1].
        data: as of `mean_dielectric`.
    """
    flat = None if data is None else data.facet_weights
    weights = _facet_weights().read_all(dr.sqrt(cos_i), dr.sqrt(alpha), data=flat)
    return sum(weight * value for weight, value in zip(weights, values, strict=True))


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


@functools.cache
def _facet_weights() -> Table:
    """Means of Lagrange's polynomials in the root of the facet's cosine."""
    roots = np.sqrt(FACET_COSINES)

    def mean(cos_i, alpha, number):
        def polynomial(wo, cos_m):
            root, value = dr.safe_sqrt(cos_m), 1
            for k, other in enumerate(roots):
                divisor = sum(
                    dr.select(number == j, float(node - other), 0) for j, node in enumerate(roots)
                )
                value *= dr.select(number == k, 1, (root - float(other)) / divisor)
            return value

        return mean_over_facets(polynomial, cos_i, alpha)

    return _tabulated(mean, np.arange(len(roots)))


def _tabulated(function: Callable[[Any, Any, Any], Any], last: np.ndarray) -> Table:
    """Evaluate a function of cosine, width and a third quantity at all nodes."""
    cosines = np.maximum(np.linspace(0, 1, COSINES) ** 2, LOWEST_COSINE)
    widths = np.maximum(np.linspace(0, 1, WIDTHS) ** 2, LOWEST_COSINE)
    nodes = np.meshgrid(cosines, widths, last, indexing="ij")
    lanes = (backend().Float(node.ravel().astype(np.float32)) for node in nodes)
    return Table(np.array(function(*lanes).numpy(), np.float32).reshape(nodes[0].shape))
