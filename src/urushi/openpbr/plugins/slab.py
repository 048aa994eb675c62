"""The rough diffuse slab of OpenPBR's dielectric base, seen through the interface."""

from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.core import eon
from urushi.openpbr import glossy, rough_slab
from urushi.openpbr.plugins.albedo import coordinates, interpolated

#: Least share of light that leaves the slab at once; less is a slab of index far above 10.
LEAST_SHARE = 1e-3


class Slab(NamedTuple):
    """The slab and its interface at a vertex.

    Attributes:
        color: base_weight times base_color. roughness: base_diffuse_roughness.
        alpha: one GGX width of the interface. eta: its index relative to the medium above.
        passed: the product of the shares of light that it passes from wi and from wo.
        passed_mean: the share of diffuse light that it passes.
    """

    color: Any
    roughness: Any
    alpha: Any
    eta: Any
    passed: Any
    passed_mean: Any


class RoughSlab:
    """Light that is transmitted, reflected by an EON slab and transmitted again; see `rough_slab`.

    The first reflection is EON along the mean directions in the slab. Light that the interface
    reflects back inside returns as diffuse light, so that a white slab conserves energy. The
    fraction that is reflected back, for light from w, is K(w), a table, and the later reflections
    are (K(wi) + K(wo) - mean K) / (pi passed_mean), whose integral over wo is K(wi). The mean is
    over the light that passes.

    eta: the interface's index if it is constant; None: any between 1/3 and 3.
    """

    def __init__(self, eta: float | None):
        self._constant = None if eta is None else float(np.clip(eta, 1 / 3, 3))
        known = rough_slab.tables(self._constant)
        table = np.stack([known.inside, known.excess], axis=-1)
        mean = known.excess_mean[..., None]
        self._table = interpolated(table if self._constant is None else table[0])
        self._mean = interpolated(mean if self._constant is None else mean[0])

    def f(self, wi, wo, slab: Slab):
        """The BRDF [1/sr] of all orders of reflection."""
        at = slab.alpha, slab.eta if self._constant is None else self._constant
        ends = [self._table(coordinates(w.z, *at)) for w in (wi, wo)]
        inside, excess = zip(*ends, strict=True)
        excess_mean = self._mean(coordinates(None, *at))[0]
        direct = dr.clip(slab.passed_mean / dr.square(slab.eta), LEAST_SHARE, 1)
        internal = 1 - direct
        rho = glossy.slab_albedo(slab.color, internal)

        cosines = eon.Cosines(inside[0], inside[1], _between(wi, wo, inside))
        first = direct * eon.f(cosines, rho, slab.roughness, dr)
        more = direct * eon.deviation(slab.roughness)
        kept = internal - more * (excess[0] + excess[1] - excess_mean)
        albedos = [eon.albedo(cosine, rho, slab.roughness, dr) for cosine in inside]
        mean_albedo = eon.mean_albedo(rho, slab.roughness)
        later = albedos[0] * albedos[1] * kept * (direct / (1 - mean_albedo * internal))
        # What is kept is less than nothing for few directions at grazing angles.
        return dr.maximum(first + dr.inv_pi * later, 0) * (slab.passed / slab.passed_mean)


def _between(wi, wo, inside):
    """Cosine of the angle in the slab: of directions with the azimuths of wi and wo."""
    sines2 = (dr.square(wi.x) + dr.square(wi.y)) * (dr.square(wo.x) + dr.square(wo.y))
    # Zero at the normal, the mean over the azimuth, which the normal does not have.
    along = (wi.x * wo.x + wi.y * wo.y) * dr.rsqrt(dr.maximum(sines2, 1e-24))
    sines = dr.safe_sqrt((1 - dr.square(inside[0])) * (1 - dr.square(inside[1])))
    return inside[0] * inside[1] + sines * dr.clip(along, -1, 1)
