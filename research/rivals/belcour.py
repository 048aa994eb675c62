"""Layered materials by statistical operators: Belcour 2018.

Each interface and each medium is an operator on the energy, the mean direction and the variance of
a lobe. Adding the layers from top to bottom gives one GGX lobe for each interface. The equations
are those of L. Belcour, Efficient Rendering of Layered Materials using an Atomic Decomposition with
Statistical Operators, ACM Transactions on Graphics 37 (4), 2018, as implemented in public ports of
the author's code (forward model). Energies and variances depend on wi alone: the BRDF is not
reciprocal.

This implementation makes four choices. Variances are those of each colour channel, not of the
channels' mean. The Fresnel mean of an interface is normalised by the lobe without Fresnel's term,
so that a single interface has the exact albedo. Scattering widens a lobe in proportion to the
medium's albedo, after equation 24 of the paper; some ports also widen it in absorbing media. A
Lambertian bottom, which the paper does not have, reflects a Lambertian lobe. As in the ports, the
refraction of a width ignores the angle, and reflectances from both sides of an interface are equal.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import drjit as dr
import numpy as np
import numpy.typing as npt

from research.rivals import belcour_tables as tables
from research.rivals import values_per_channel
from research.rivals.belcour_bottoms import Bottom, table_bottom
from urushi import checks
from urushi.checks import MIN_ALPHA, CoatParameters, Widths
from urushi.core import microfacet
from urushi.errors import ParameterError
from urushi.walk import Conductor, Dielectric, Diffuse, Stack
from urushi.walk.monte_carlo import backend
from urushi.walk.table import StackTable, TableLayers

#: Exponent of the variance's formula (equation 6).
VARIANCE_EXPONENT = 1.1
#: Largest width and smallest asymmetry that have a finite variance.
MAX_ALPHA, MIN_G = 0.9999, 1e-4
#: Least cosine in a medium, and least divisor of the sum of reflections between layers.
MIN_COSINE, MIN_DIVISOR = 1e-3, 1e-6

#: Function of a variance and of the incident cosine that gives the width of a lobe for the tables.
Seen = Callable[[Any, Any], Any]


class Lobe(NamedTuple):
    """A lobe of the sum: its energy, and its GGX width, None of a Lambertian lobe."""

    energy: Any
    alpha: Any


class Layer(NamedTuple):
    """An interface or a medium: energies r, t and variances s; "back" is from below.

    `stretch` scales a variance that passes downwards, `stretch_back` one that passes upwards.
    """

    r: Any
    t: Any
    r_back: Any
    t_back: Any
    s_r: Any
    s_t: Any
    s_t_back: Any
    stretch: Any
    stretch_back: Any


class Sum(NamedTuple):
    """The layers added so far: the reflectance from below, the transmittances, and variances."""

    r_back: Any
    t: Any
    t_back: Any
    s_r_back: Any
    s_t: Any
    s_t_back: Any
    stretch: Any
    stretch_back: Any


def f(stack: Stack, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
    """Evaluate the model of Belcour 2018.

    Args:
        stack: isotropic coats over a conductor, a dielectric or a diffuse bottom.
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal.

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
            "belcour.f needs a Stack over a conductor, dielectric or diffuse bottom; describe it "
            "by urushi.coat(...)"
        )
    if stack.is_anisotropic:
        raise ParameterError(
            "belcour.f supports isotropic lobes only, but a surface of the stack has two widths; "
            "give alpha instead of alpha_u and alpha_v, or call weier.f"
        )
    return values_per_channel(stack, checks.directions(wi, wo), rows)


def rows(table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Evaluate row[i] of a table of isotropic stacks at (wi[i], wo[i]); float32 (M,) [1/sr]."""
    device = backend()
    index = device.UInt32(np.ascontiguousarray(row, np.uint32))
    to_light, to_eye = (device.Array3f(np.ascontiguousarray(w.T, np.float32)) for w in (wi, wo))
    found = lobes(table, index, dr.clip(to_light.z, MIN_COSINE, 1))
    return np.array(value(found, to_light, to_eye).numpy(), np.float32)


def value(found: Sequence[Lobe], wi: Any, wo: Any) -> Any:
    """The sum of lobes, which are those of wi, at wo [1/sr]; zero below the horizon."""
    total = type(wi.z)(0)
    for lobe in found:
        if lobe.alpha is None:
            total += lobe.energy * dr.inv_pi
        else:
            total += lobe.energy * microfacet.reflection_lobe(wi, wo, lobe.alpha)[0]
    return dr.select((wi.z > 0) & (wo.z > 0), total, 0)


def lobes(table: StackTable, row: Any, cos_i: Any) -> list[Lobe]:
    """The lobes of stacks row[i] of a table: one an interface, the bottom's last.

    Args:
        table: isotropic stacks over a described bottom.
        row: Dr.Jit indices (M,).
        cos_i: cosine of the incident direction, Dr.Jit floats (M,) in (0, 1].
    """
    if isinstance(table.alpha, Widths) or "alpha_u" in table.bottom:
        raise ParameterError("lobes supports isotropic surfaces only; the table has two widths")
    layers = TableLayers(backend(), table, row)
    places = [type(row)(i) for i in range(layers.count)]
    coats = [CoatParameters(*layers.interface(i), *layers.medium(i)) for i in places]
    return added_lobes(coats, table_bottom(table, row, type(cos_i)), cos_i)


def added_lobes(
    coats: Sequence[CoatParameters],
    bottom: Bottom,
    cos_i: Any,
    data: tables.Data | None = None,
    seen: Seen | None = None,
) -> list[Lobe]:
    """The lobes of a stack: one an interface, the bottom's last.

    Args:
        coats: coats from top to bottom; their parameters are Dr.Jit floats. A width may be a Dr.Jit
            vector of the widths along several axes, each of which is added by itself.
        bottom: what is under them.
        cos_i: cosine of the incident direction, Dr.Jit floats in (0, 1].
        data: the tables in arrays of that type, `tables.data`; None: they are copied to it.
        seen: the width at which the tables are read for a lobe; None: the lobe's own. It is needed
            where widths, and with them variances, are Dr.Jit vectors of several axes.
    """
    data, seen = data or tables.data(type(cos_i)), seen or _own_width
    one, zero = type(cos_i)(1), type(cos_i)(0)
    total = Sum(zero, one, one, zero, zero, zero, one, one)
    found, eta_above = [], one
    for coat in coats:
        surface, cos_t = interface(cos_i, coat.alpha, coat.eta, total.s_t, data, seen)
        spread = seen(total.s_t + surface.s_r, cos_i)
        share = tables.transmitted_share(cos_i, spread, 1 / eta_above, data)
        total, energy, spread = add(totally_reflected(total, share), surface)
        found.append(Lobe(energy, width(spread)))
        total = add(total, medium(cos_t, coat.albedo, coat.sigma_t, coat.g))[0]
        cos_i, eta_above = cos_t, coat.eta
    energy, spread = _bottom(total, bottom, cos_i, eta_above, data, seen)
    return [*found, Lobe(energy, spread)]


def interface(
    cos_i: Any,
    alpha: Any,
    eta: Any,
    s_t: Any,
    data: tables.Data | None = None,
    seen: Seen | None = None,
) -> tuple[Layer, Any]:
    """The operators of a dielectric interface, and the mean cosine below it.

    s_t is the variance that the light from above has; it widens the Fresnel mean. `seen` is that of
    `added_lobes`.
    """
    seen = seen or _own_width
    sin2_t = (1 - cos_i * cos_i) / (eta * eta)
    passes = sin2_t < 1
    cos_t = dr.maximum(dr.safe_sqrt(1 - sin2_t), MIN_COSINE)
    s_r = variance(alpha)
    r = tables.mean_dielectric(cos_i, seen(s_t + s_r, cos_i), eta, data)
    r = dr.select(passes, r, 1)
    bend = 0.5 * dr.abs(eta - 1)
    stretch = dr.select(passes, eta * cos_t / cos_i, 1)
    t = 1 - r
    layer = Layer(
        r, t, r, t, s_r, variance(alpha * bend / eta), variance(alpha * bend), stretch, 1 / stretch
    )
    return layer, cos_t


def medium(cos_i: Any, albedo: Any, sigma_t: Any, g: Any) -> Layer:
    """The operators of a medium: absorption (equation 15) and forward scattering (22, 24)."""
    depth = sigma_t / cos_i
    t = (1 + albedo * depth) * dr.exp(-depth)
    g = dr.clip(g, MIN_G, 1)
    s_t = dr.select(sigma_t > 0, albedo, 0) * dr.power((1 - g) / g, 0.8) / (1 + g)  # equation 21
    zero, one = type(t)(0), type(t)(1)
    return Layer(zero, t, zero, t, zero, s_t, s_t, one, one)


def totally_reflected(total: Sum, share: Any) -> Sum:
    """Return to below what is beyond the critical angle; `share` of the light is not."""
    r_back = dr.clip(total.r_back + (1 - share) * total.t_back, 0, 1)
    return total._replace(r_back=r_back, t_back=share * total.t_back)


def add(total: Sum, layer: Layer) -> tuple[Sum, Any, Any]:
    """Add a layer below; returns (sum, energy of the layer's lobe, its variance)."""
    inverse = 1 / dr.maximum(1 - total.r_back * layer.r, MIN_DIVISOR)
    energy = total.t * layer.r * total.t_back * inverse
    between = total.r_back * layer.r * inverse
    again = between * (layer.s_r + total.s_r_back)
    spread = total.s_t_back + total.stretch * (total.s_t + layer.s_r + again)
    below = layer.t_back * total.r_back * layer.t * inverse
    r_back = layer.r_back + below
    s_below = layer.s_t + layer.stretch * (layer.s_t_back + total.s_r_back + again)
    s_r_back = layer.r_back * layer.s_r + below * s_below
    added = Sum(
        r_back,
        total.t * layer.t * inverse,
        layer.t_back * total.t_back * inverse,
        dr.select(r_back > 0, s_r_back / dr.maximum(r_back, MIN_DIVISOR), 0),
        layer.stretch * (total.s_t + again) + layer.s_t,
        total.stretch_back * (layer.s_t_back + again) + total.s_t_back,
        total.stretch * layer.stretch,
        total.stretch_back * layer.stretch_back,
    )
    return added, energy, spread


def variance(alpha: Any) -> Any:
    """The variance of a GGX lobe (equation 6)."""
    power = dr.power(dr.clip(alpha, 1e-6, MAX_ALPHA), VARIANCE_EXPONENT)
    return power / (1 - power)


def width(variance: Any) -> Any:
    """The GGX width of a variance, the inverse of `variance`, at least 0.01."""
    alpha = dr.power(variance / (1 + variance), 1 / VARIANCE_EXPONENT)
    return dr.clip(alpha, MIN_ALPHA, 1)


def _own_width(variance: Any, cos_i: Any) -> Any:
    """The `Seen` of isotropic lobes."""
    return width(variance)


def _bottom(
    total: Sum, bottom: Bottom, cos_i: Any, eta_above: Any, data: tables.Data, seen: Seen
) -> tuple[Any, Any]:
    """Energy and width of the bottom's lobe; the width is None if it is Lambertian."""
    zero, one = type(cos_i)(0), type(cos_i)(1)
    if bottom.alpha is None:
        s_r, r = zero, bottom.reflectance(cos_i, zero)
        share = dr.minimum(1 / (eta_above * eta_above), 1)  # the cosine lobe's, exactly
    else:
        s_r = variance(bottom.alpha)
        widened = seen(total.s_t + s_r, cos_i)
        r = bottom.reflectance(cos_i, widened)
        share = tables.transmitted_share(cos_i, widened, 1 / eta_above, data)
    opaque = Layer(r, zero, zero, zero, s_r, zero, zero, one, one)
    _, energy, spread = add(totally_reflected(total, share), opaque)
    return energy, None if bottom.alpha is None else width(spread)
