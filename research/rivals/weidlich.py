"""Layered materials by one path through a common facet: Weidlich and Wilkie 2007.

A layer's facets are taken as much wider than the layer is thick, so that light leaves by the facet
that it entered by. That facet's normal is the half vector of wi and wo. Both directions are
refracted by it, and the BRDF below is evaluated for the two refracted directions. Light takes one
path from each interface: nothing is reflected between layers, and no medium scatters.

A. Weidlich and A. Wilkie, Arbitrarily Layered Micro-Facet Surfaces, GRAPHITE 2007, as explained by
I. Kabel, Rendering Layered Materials, 2018, from which the equations were read:
f = f1(wi, wo) + T12 f2(wi', wo') a t, with Beer's law a and t = (1 - G) + T21 G. The masking G is
taken as the upper interface's. As in the paper, radiance is not scaled for the solid angle that
refraction changes: coated metals are too dark at grazing angles, coated Lambertian surfaces too
bright. White ones then reflect more than they receive, and so do coats of an index below one.
"""

from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from research.rivals import values_per_channel
from urushi import checks
from urushi.core import fresnel, microfacet
from urushi.core.directions import refract
from urushi.errors import ParameterError
from urushi.walk import Stack
from urushi.walk.bottoms import Bottom
from urushi.walk.monte_carlo import backend
from urushi.walk.table import StackTable, TableLayers, table_bottom
from urushi.walk.walk import Layers


def f(stack: Stack, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
    """Evaluate the model of Weidlich and Wilkie 2007.

    Args:
        stack: coats over any bottom; their media absorb by `sigma_t`, whatever `albedo` and `g`.
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal.

    Returns:
        float32 (N, 3): the BRDF [1/sr], without cosine; zero below the horizon. It is reciprocal
        where the bottom is.

    Raises:
        ParameterError: no stack; wrong shapes or no unit vectors.
        PlatformError: no libLLVM that Dr.Jit can use.
    """
    if not isinstance(stack, Stack):
        raise ParameterError("weidlich.f needs a Stack; describe it by urushi.coat(...)")
    return values_per_channel(stack, checks.directions(wi, wo), rows)


def rows(table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Evaluate row[i] of a table of stacks at (wi[i], wo[i]); float32 (M,) [1/sr]."""
    device = backend()
    index = device.UInt32(np.ascontiguousarray(row, np.uint32))
    to_light, to_eye = (device.Array3f(np.ascontiguousarray(w.T, np.float32)) for w in (wi, wo))
    layers, bottom = TableLayers(device, table, index), table_bottom(device, table, index)
    return np.array(value(layers, bottom, to_light, to_eye).numpy(), np.float32)


def value(layers: Layers, bottom: Bottom, wi: Any, wo: Any) -> Any:
    """The BRDF [1/sr] of layers over a bottom, Dr.Jit floats or colours; 0 below the horizon."""
    index_type = dr.uint32_array_t(type(wi.z))
    above = (wi.z > 0) & (wo.z > 0)
    normal = type(wi)(0, 0, 1)
    wi, wo = dr.select(above, wi, normal), dr.select(above, wo, normal)
    facet = dr.normalize(wi + wo)  # of all interfaces: refraction by it keeps it the half vector
    total, passed = type(wi.z)(0), dr.select(above, type(wi.z)(1), 0)
    for i in range(layers.count):
        alpha, eta = layers.interface(index_type(i))
        lobe, cos_i = microfacet.reflection_lobe(wi, wo, alpha)
        reflectance, cos_t = fresnel.dielectric(dr.clip(cos_i, 0, 1), eta)
        total = total + passed * lobe * reflectance
        masking = microfacet.smith_g1(wi, alpha) * microfacet.smith_g1(wo, alpha)
        leaves = (1 - masking) + (1 - reflectance) * masking
        wi, wo = (-refract(w, facet, cos_t, eta) for w in (wi, wo))
        enters = (reflectance < 1) & (wi.z > 0) & (wo.z > 0)
        wi, wo = dr.select(enters, wi, normal), dr.select(enters, wo, normal)
        sigma_t = layers.medium(index_type(i))[1]
        absorbed = dr.exp(-sigma_t * (1 / wi.z + 1 / wo.z))
        passed = dr.select(enters, passed * (1 - reflectance) * leaves * absorbed, 0)
    return total + passed * bottom.f_pdf(wi, wo)[0]
