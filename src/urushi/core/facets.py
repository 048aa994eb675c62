"""Light that meets more than one facet of a GGX reflector.

A lobe of single scattering loses it. The lobe of `multiple_lobe` gives it back. It is reciprocal,
and facets that reflect all light then have an albedo of one (Kulla and Conty 2017, with the
Fresnel term of Jimenez and Hanika in their notes).
"""

from typing import Any

import drjit as dr
import numpy as np

from urushi.checks import Widths
from urushi.core import albedos, anisotropic_albedos
from urushi.core.lanes import interpolated
from urushi.core.namespace import DRJIT

#: An index of refraction whose facets reflect all light.
MIRROR = 1e8


def multiple_albedo(fresnel_mean: Any, seen_mean: Any) -> Any:
    """The albedo of light that facets reflect more than once.

    fresnel_mean: cosine-weighted mean of their Fresnel term. seen_mean: share of diffuse light
    that leaves the surface after one reflection if its facets reflect all light.
    """
    return fresnel_mean * fresnel_mean * seen_mean / (1 - fresnel_mean * (1 - seen_mean))


def multiple_lobe(seen_i: Any, seen_o: Any, seen_mean: Any, fresnel_mean: Any) -> Any:
    """The lobe [1/sr] of light that meets more than one facet, on Dr.Jit arrays.

    seen_i, seen_o: as `seen_mean`, of the light from both directions. The other arguments are those
    of `multiple_albedo`.
    """
    color = multiple_albedo(fresnel_mean, seen_mean)
    # Where nothing is lost, the quotient is 0 / 0.
    return color * ((1 - seen_i) * (1 - seen_o) / dr.maximum(dr.pi * (1 - seen_mean), 1e-6))


class SeenLight:
    """Shares of light that leave a surface after one reflection if facets reflect all light."""

    def __init__(self, alpha: Any):
        """alpha: GGX width or `Widths`, Dr.Jit floats."""
        self._alpha, two = alpha, isinstance(alpha, Widths)
        scalar = type(alpha.u if two else alpha)
        tables = (anisotropic_albedos if two else albedos).tables(MIRROR)
        self._tables = [
            (scalar(np.ascontiguousarray(x.ravel())), x.shape[1:])
            for x in (tables.reflected, tables.reflected_mean)
        ]

    def of(self, w: Any) -> Any:
        """The share of the light from directions w above the horizon."""
        return self._at(0, [albedos.cosine_coordinate(w.z, xp=DRJIT), *self._place(w)])

    @property
    def mean(self) -> Any:
        """The share of diffuse light."""
        return self._at(1, self._place(None))

    def _place(self, w: Any) -> list:
        if isinstance(self._alpha, Widths):
            return anisotropic_albedos.coordinates(w, self._alpha, DRJIT)
        return [albedos.roughness_coordinate(self._alpha, DRJIT)]

    def _at(self, table: int, places: list) -> Any:
        flat, shape = self._tables[table]
        return interpolated(flat, shape, places[::-1], dr.uint32_array_t(type(flat))(0))
