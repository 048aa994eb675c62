"""The Fresnel term of the metal: F82-tint."""

from typing import Any

import numpy as np

#: The cosine at which `specular_color` tints Schlick's reflectance, about 82 degrees.
EDGE_COSINE = 1 / 7

_EDGE = (1 - EDGE_COSINE) ** 5


#: Gauss-Legendre nodes of the mean over the cosine, and weights of 2 cos dcos: exact where `f82` is
#: a polynomial, and within 0.0013 where it is clamped.
_NODES, _WEIGHTS = (0.5 * x for x in np.polynomial.legendre.leggauss(8))
_NODES = _NODES + 0.5
_WEIGHTS = 2 * _WEIGHTS * _NODES


def f82(cosine: Any, f0: Any, tint: Any, xp: Any = np) -> Any:
    """Reflectance of a metal: Schlick's term with a dip towards the edge.

    Args:
        cosine: of the angle between the light and the facet, in [0, 1].
        f0: reflectance at normal incidence, base_weight times base_color.
        tint: specular_color, the fraction of Schlick's term that is left at 82 degrees.
        xp: the module of the arrays' functions, NumPy or drjit.

    Returns:
        The reflectance, in [0, 1]; specular_weight multiplies it. The dip of a dark metal with a
        dark tint is deeper than Schlick's term and is clamped, as in Adobe's openpbr-bsdf.

    Source: Kutz, Hasan and Edmondson 2021, Novel aspects of the Adobe Standard Material.
    """
    away = 1 - cosine
    fifth = away * away * away * away * away
    schlick = f0 + (1 - f0) * fifth
    edge = f0 + (1 - f0) * _EDGE
    dip = cosine * fifth * away * (1 / (EDGE_COSINE * _EDGE * (1 - EDGE_COSINE)))
    value = schlick - dip * edge * (1 - tint)
    # A selection, not a maximum, has gradients at zero.
    return (xp.where if xp is np else xp.select)(value < 0, 0, value)


def f82_mean(f0: Any, tint: Any, xp: Any = np) -> Any:
    """The cosine-weighted mean of `f82` over the hemisphere, 2 times the integral of F cos."""
    nodes = zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True)
    return sum(weight * f82(cosine, f0, tint, xp) for cosine, weight in nodes)
