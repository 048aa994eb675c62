"""Directional albedos of rough slabs below interfaces: tables and look-ups.

The nodes are defined in `core.albedos`, and in `core.anisotropic_albedos` for two widths.
"""

import functools

import drjit as dr
import numpy as np

from urushi.core import albedos
from urushi.core.albedos import between_nodes, indexnodes
from urushi.core.namespace import DRJIT
from urushi.mitsuba.tables import Interpolated, albedo_coordinates
from urushi.openpbr_surface import formulas

#: Lower bound of the share of light that leaves the slab at once; an index of 10 gives more.
LEAST_SHARE = 1e-3


# The first reflection by a rough white slab below an interface. The facets pass light from a
# direction, which is then assumed to have their mean cosine in the slab. Of its first reflection by
# a Lambertian slab, the interface passes the share passed_mean / eta^2, whatever the direction. EON
# reflects more or less towards directions that the interface passes. The deviation is proportional
# to `formulas.eon_deviation`, so that one table serves all roughnesses of the slab.


@functools.cache
def slab_tables(eta: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Tables of a white slab below an interface, float32, for a base_diffuse_roughness of one.

    eta: the only index, I is 1; None: all of `indexnodes`.

    Returns:
        (I, ROUGHNESSES, COSINES, 2): the mean cosine in the slab; and the relative excess of the
        light that leaves over the light that leaves a Lambertian slab. (I, ROUGHNESSES, 1): the
        mean of the excess over the transmitted part of diffuse light.
    """
    known = albedos.tables(eta)
    etas = indexnodes() if eta is None else np.array([eta])
    inside = np.clip(known.inside.astype(np.float64), 0, 1)
    passed, weight = between_nodes(1 - known.reflected.astype(np.float64), etas)
    weights = passed * weight
    weights /= weights.sum(-1, keepdims=True)
    away, _ = between_nodes(inside)
    single = np.empty_like(inside)
    for k in range(inside.shape[-1]):
        along = formulas.eon_single_over_azimuths(inside[..., k, None], away, 1.0)
        single[..., k] = (weights * along).sum(-1)
    lost = 1 - formulas.eon_single_albedo(inside, 1.0)
    lost_mean = (weights * (1 - formulas.eon_single_albedo(away, 1.0))).sum(-1, keepdims=True)
    excess = single + lost * lost_mean / (1 - formulas.eon_single_mean(1.0)) - 1
    mean = (weights * between_nodes(excess)[0]).sum(-1, keepdims=True)
    return np.stack([inside, excess], axis=-1).astype(np.float32), mean.astype(np.float32)


class RoughSlab:
    """Light that is transmitted, reflected by an EON slab and transmitted again.

    The first reflection is EON along the mean directions in the slab. Light that the interface
    reflects back inside returns as diffuse light, so that a white slab conserves energy. The
    fraction that is reflected back, for light from w, is K(w), a table, and the later reflections
    are (K(wi) + K(wo) - mean K) / (pi passed_mean), whose integral over wo is K(wi). The mean is
    over the light that passes.

    eta: the interface's index if it is constant; None: any between 1/3 and 3.
    """

    def __init__(self, eta: float | None):
        self._constant, known = eta, slab_tables(eta)
        self._table, self._mean = (Interpolated(x if eta is None else x[0]) for x in known)

    def f(self, wi, wo, color, roughness, interface: tuple, passed, passed_mean):
        """The BRDF [1/sr] of all orders of reflection.

        color: base_weight times base_color. roughness: base_diffuse_roughness.
        interface: its GGX width, and its index relative to the medium above.
        passed: the product of the shares of light that it passes from wi and from wo.
        passed_mean: the share of diffuse light that it passes.
        """
        alpha, eta = interface
        at = alpha, eta if self._constant is None else self._constant
        ends = [self._table(albedo_coordinates(w.z, *at)) for w in (wi, wo)]
        inside, excess = zip(*ends, strict=True)
        excess_mean = self._mean(albedo_coordinates(None, *at))[0]
        direct = dr.clip(passed_mean / dr.square(eta), LEAST_SHARE, 1)
        internal = 1 - direct
        rho = formulas.slab_albedo(color, internal)

        cosines = inside[0], inside[1], _between(wi, wo, inside)
        first = direct * formulas.eon(*cosines, rho, roughness, DRJIT)
        more = direct * formulas.eon_deviation(roughness)
        kept = internal - more * (excess[0] + excess[1] - excess_mean)
        albedos = [formulas.eon_albedo(cosine, rho, roughness, DRJIT) for cosine in inside]
        mean_albedo = formulas.eon_mean_albedo(rho, roughness)
        later = albedos[0] * albedos[1] * kept * (direct / (1 - mean_albedo * internal))
        # `kept` is negative for few directions at grazing angles.
        return dr.maximum(first + dr.inv_pi * later, 0) * (passed / passed_mean)


def _between(wi, wo, inside):
    """Cosine of the angle in the slab: of directions with the azimuths of wi and wo."""
    sines2 = (dr.square(wi.x) + dr.square(wi.y)) * (dr.square(wo.x) + dr.square(wo.y))
    # Zero at the normal, the mean over the azimuth, which the normal does not have.
    along = (wi.x * wo.x + wi.y * wo.y) * dr.rsqrt(dr.maximum(sines2, 1e-24))
    sines = dr.safe_sqrt((1 - dr.square(inside[0])) * (1 - dr.square(inside[1])))
    return inside[0] * inside[1] + sines * dr.clip(along, -1, 1)
