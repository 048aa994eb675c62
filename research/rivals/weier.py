"""Anisotropic layered materials by statistical operators: Weier and Belcour 2020.

The operators of Belcour 2018 (`research.rivals.belcour`), with the covariance of a lobe in the
tangent plane in place of its variance. All layers share a tangent, so that every covariance matrix
is diagonal in it, and layers are added on each axis by itself. Every interface gives one
anisotropic GGX lobe. P. Weier and L. Belcour, Rendering Layered Materials with Anisotropic
Interfaces, Journal of Computer Graphics Techniques 9 (2), 2020.

Only the paper's abstract and a public port were available, not the paper's text or its authors'
code. The abstract has the diagonal covariance, the adding on each axis, and mean reflectances that
account for both widths. The port has the variance of each width by equation 6 of Belcour 2018,
refraction that stretches both axes equally, and energies common to both. So does the code of T.
Yamaguchi et al., Real-Time Rendering of Layered Materials with Anisotropic Normal Distributions,
2019, whose layers may be rotated relative to each other.

This module derives the width with which tables of isotropic surfaces are read for mean reflectances
and total reflection (`seen_width`). The abstract also mentions a new formula for the variance,
which was not available. All other choices are those of `belcour`: both models agree for equal
widths.
"""

from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from research.rivals import belcour, values_per_channel
from research.rivals.belcour import Lobe
from research.rivals.belcour_bottoms import table_bottom
from urushi import checks
from urushi.checks import CoatParameters, Widths
from urushi.core import microfacet
from urushi.errors import ParameterError
from urushi.walk import Conductor, Dielectric, Diffuse, Stack
from urushi.walk.monte_carlo import backend
from urushi.walk.table import StackTable, TableLayers


def f(stack: Stack, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
    """Evaluate the model of Weier and Belcour 2020.

    Args:
        stack: coats over a conductor, a dielectric or a diffuse bottom, of one width or two.
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal, x the tangent.

    Returns:
        float32 (N, 3): the BRDF [1/sr], without cosine; zero below the horizon. It is not
        reciprocal: wi is the direction whose lobes are added.

    Raises:
        ParameterError: the model does not describe the stack; wrong shapes or no unit vectors.
        PlatformError: no libLLVM that Dr.Jit can use.
    """
    if not isinstance(stack, Stack) or not isinstance(
        stack.bottom, Conductor | Dielectric | Diffuse
    ):
        raise ParameterError(
            "weier.f needs a Stack over a conductor, dielectric or diffuse bottom; describe it "
            "by urushi.coat(...)"
        )
    return values_per_channel(stack, checks.directions(wi, wo), rows)


def rows(table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Evaluate row[i] of a table of stacks at (wi[i], wo[i]); float32 (M,) [1/sr]."""
    device = backend()
    index = device.UInt32(np.ascontiguousarray(row, np.uint32))
    to_light, to_eye = (device.Array3f(np.ascontiguousarray(w.T, np.float32)) for w in (wi, wo))
    found = lobes(table, index, to_light)
    return np.array(belcour.value(found, to_light, to_eye).numpy(), np.float32)


def lobes(table: StackTable, row: Any, wi: Any) -> list[Lobe]:
    """The lobes of stacks row[i] of a table: one an interface, the bottom's last.

    Args:
        table: stacks over a described bottom, of one width or two.
        row: Dr.Jit indices (M,).
        wi: incident directions, Dr.Jit vectors (M,), above the horizon.

    Returns:
        Lobes whose alpha is `Widths`, or None of a Lambertian one.
    """
    layers = TableLayers(backend(), table, row)
    coats = []
    for i in range(layers.count):
        alpha, eta = layers.interface(type(row)(i))
        coats.append(CoatParameters(_axes(alpha), eta, *layers.medium(type(row)(i))))
    cos_i = dr.clip(wi.z, belcour.MIN_COSINE, 1)

    def seen(covariance: Any, cos_i: Any) -> Any:
        return seen_width(belcour.width(covariance), wi, cos_i)

    bottom = table_bottom(table, row, type(cos_i))
    if bottom.alpha is not None and "alpha" in table.bottom:
        bottom = bottom._replace(alpha=_axes(bottom.alpha))
    found = belcour.added_lobes(coats, bottom, cos_i, seen=seen)
    return [
        lobe if lobe.alpha is None else Lobe(lobe.energy, Widths(lobe.alpha.x, lobe.alpha.y))
        for lobe in found
    ]


def seen_width(alpha: Any, wi: Any, cos_i: Any) -> Any:
    """The width of an isotropic lobe that has about the mean reflectance of an anisotropic one.

    Facets tilted towards the incident direction change its angle of incidence, by the sine of its
    own angle: there the width in the plane of incidence counts (Heitz 2014, eq. 80). Near the
    normal, both axes count alike. So the square is the mean of both squares, weighed by the squared
    sine and cosine. For an index of 1.5 and quotients of the widths up to 8, mean reflectances are
    3 % off on average; by the geometric mean of the widths, they would be 10 % off.

    Args:
        alpha: the two widths, a Dr.Jit vector.
        wi: incident direction; its azimuth alone is used.
        cos_i: cosine of the direction in the layer, in (0, 1].
    """
    u2, v2 = alpha.x * alpha.x, alpha.y * alpha.y
    x2, y2 = wi.x * wi.x, wi.y * wi.y
    along = dr.select(x2 + y2 > 0, x2 / dr.maximum(x2 + y2, 1e-30), 0.5)
    cos2 = cos_i * cos_i
    squared = v2 + (u2 - v2) * (0.5 * cos2 + along * (1 - cos2))
    return dr.sqrt(squared)


def _axes(alpha: Any) -> Any:
    """One width or two as the Dr.Jit vector of both."""
    return backend().Array2f(*microfacet.pair(alpha))
