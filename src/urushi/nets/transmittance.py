"""The transmittance of a material's topmost interface, where it is one to a thinner medium.

All light that a material reflects, but for its lobe, passes this interface twice. From the denser
side, an interface reflects totally beyond the critical angle. The rest of f so has edges in both
directions, which no smooth function of them draws. It is therefore

    f(wi, wo) = lobe + T(wi) T(wo) g(wi, wo),

with T of a formula, and g of the table or the code of a material. T is one for all other lobes.

T follows the rough interface with an error that g takes up. Let c be the cosine of a direction, s
its sine, c0 the cosine of the critical angle, and w = alpha s, about the spread of the cosines
between the direction and facets. With r(x, w) = (x + sqrt(x^2 + w^2)) / 2, a ramp whose edge has
the width w, and the share P(x) = r(x, w) / sqrt(x^2 + w^2) of GGX slopes below x / w,

    T = P(c - c0) / P(c) (1 - F),

where F is Fresnel's reflectance for the refracted cosine with the square
r((c^2 - c0^2) / eta^2, 2 w c0 / eta^2). T goes to one where eta does.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core.namespace import Namespace, arrays, components
from urushi.core.quadrature import EDGE_NODES, POLAR_NODES
from urushi.core.table import MIN_COSINE, node_pairs, table_of_values
from urushi.nets import lobe as lobes

#: Least square of the width w.
LEAST_WIDTH2 = 1e-9

#: Least index in divisions.
LEAST_INDEX = 1e-3


def remainder(f: Any, lobe: Any, wi: Any, wo: Any) -> Any:
    """g (...) [1/sr] of values f (...) of materials with lobes (..., N), for directions (..., 3).

    The arguments broadcast. f may be below the lobe by errors; g is at least zero.
    """
    xp = arrays(wi)
    return xp.maximum(f - lobes.f(lobe, wi, wo), 0.0) / both_ways(lobe, wi, wo)


def table_beside(f: np.ndarray, lobe: np.ndarray) -> np.ndarray:
    """The table float16 (U, V, W, C) of g of values f (N, C) [1/sr] at `core.table.node_pairs`.

    lobe: (C, N) of the channels.
    """
    return table_of_values(remainder(f, lobe, *(w[:, None] for w in node_pairs())))


def both_ways(lobe: Any, wi: Any, wo: Any) -> Any:
    """T(wi) T(wo) (...) of materials with lobes (..., N), for directions (..., 3).

    The arguments broadcast. wi and wo are above the horizon.
    """
    if not has_edges(lobe).any():
        shape = np.broadcast_shapes(*(x.shape[:-1] for x in (lobe, wi, wo)))
        return np.ones(shape, np.result_type(lobe, wi))
    return of_lobe(lobe, wi) * of_lobe(lobe, wo)


def has_edges(lobe: np.ndarray) -> np.ndarray:
    """Whether T is not one, of lobes (..., N); bool (...)."""
    return (lobe[..., 3] > 0) & (lobe[..., 4] < 1) & (lobe[..., 5] == 0)


def polar_nodes(lobe: np.ndarray) -> int:
    """Nodes in ln tan theta_h by which albedos of materials with lobes (..., N) are integrated."""
    return EDGE_NODES if has_edges(lobe).any() else POLAR_NODES


def of_lobe(lobe: Any, w: Any) -> Any:
    """T (...) of lobes (..., N), see `nets.lobe`, for directions (..., 3) above the horizon."""
    numbers = [lobe[..., place] for place in (3, 4, 5)]
    return transmittance(lobes.width(lobe), numbers, components(w), arrays(lobe))


def transmittance(alpha: Any, numbers: Sequence[Any], w: Any, xp: Namespace) -> Any:
    """T of an interface of a GGX width alpha, or of two `Widths`, for a direction.

    numbers: as of `of_spread`.
    """
    return of_spread(spread2(alpha, w, xp), numbers, w.z, xp)


def spread2(alpha: Any, w: Any, xp: Namespace) -> Any:
    """The square of the width w of the module, for a GGX width or two `Widths`."""
    if isinstance(alpha, Widths):
        x, y = alpha.u * w.x, alpha.v * w.y
        found = x * x + y * y
    else:
        found = alpha * alpha * (1.0 - w.z * w.z)
    return xp.named("spread2", xp.maximum(found, LEAST_WIDTH2))


def of_spread(spread2: Any, numbers: Sequence[Any], cosine: Any, xp: Namespace) -> Any:
    """T of an interface for a direction of this cosine.

    numbers: the factor of its Fresnel term, and its index eta - i k; the factor is None for one,
    and k for a dielectric.
    """
    factor, eta, k = numbers
    if k is not None:
        eta = xp.named("index", xp.where(k > 0.0, 1.0, eta))
    thinner = xp.named("thinner", xp.maximum(xp.minimum(eta, 1.0), LEAST_INDEX))
    share = of_dielectric(spread2, thinner, cosine, xp)
    if factor is not None:
        share = 1.0 - factor * (1.0 - share)
    return xp.where(eta < 1.0, share, 1.0)


def of_dielectric(spread2: Any, eta: Any, cosine: Any, xp: Namespace) -> Any:
    """T of a dielectric interface of an index of at most one."""
    named = xp.named
    c = named("above", xp.maximum(cosine, MIN_COSINE))
    c02 = named("critical2", xp.positive(1.0 - eta * eta))
    beyond = named("beyond", c - xp.safe_sqrt(c02))
    below, size = ramp(beyond, spread2, xp, "_beyond")
    all_below, all_size = ramp(c, spread2, xp, "_all")
    scale = named("per_index", 1.0 / (eta * eta))
    inside2, _ = ramp(
        named("straight2", (c * c - c02) * scale),
        named("blur2", 4.0 * spread2 * c02 * scale * scale + 1e-12),
        xp,
        "_inside",
    )
    inside = named("inside", xp.sqrt(xp.minimum(inside2, 1.0)))
    s, p = named("across", c + eta * inside), named("along", eta * c + inside)
    passed = 2.0 * eta * c * inside * (1.0 / (s * s) + 1.0 / (p * p))
    return named("transmittance", passed * (below * all_size) / (size * all_below))


def ramp(x: Any, width2: Any, xp: Namespace, suffix: str) -> tuple[Any, Any]:
    """r = (x + root) / 2 without loss of digits, and root = sqrt(x^2 + width2).

    suffix: of the names of its variables.
    """
    root = xp.named(f"root{suffix}", xp.sqrt(x * x + width2))
    high = xp.named(f"high{suffix}", 0.5 * (xp.absolute(x) + root))
    return xp.named(f"ramp{suffix}", xp.where(x > 0.0, high, 0.25 * width2 / high)), root
