"""The Fresnel term of the metal: F82-tint."""

from typing import Any

#: The cosine at which `specular_color` tints Schlick's reflectance, about 82 degrees.
EDGE_COSINE = 1 / 7

_EDGE = (1 - EDGE_COSINE) ** 5


def f82(cosine: Any, f0: Any, tint: Any) -> Any:
    """Reflectance of a metal: Schlick's term with a dip towards the edge.

    Args:
        cosine: of the angle between the light and the facet, in [0, 1].
        f0: reflectance at normal incidence, base_weight times base_color.
        tint: specular_color, the fraction of Schlick's term that is left at 82 degrees.

    Returns:
        The reflectance, in [0, 1]; specular_weight multiplies it.

    Source: Kutz, Hasan and Edmondson 2021, Novel aspects of the Adobe Standard Material.
    """
    away = 1 - cosine
    fifth = away * away * away * away * away
    schlick = f0 + (1 - f0) * fifth
    edge = f0 + (1 - f0) * _EDGE
    dip = cosine * fifth * away * (1 / (EDGE_COSINE * _EDGE * (1 - EDGE_COSINE)))
    return schlick - dip * edge * (1 - tint)


def f82_mean(f0: Any, tint: Any) -> Any:
    """The cosine-weighted mean of `f82` over the hemisphere, 2 times the integral of F cos."""
    edge = f0 + (1 - f0) * _EDGE
    # Integrals of 2 c (1 - c)^5 and of 2 c^2 (1 - c)^6 over [0, 1]: 1 / 21 and 1 / 126.
    dip = 1 / 126 / (EDGE_COSINE * _EDGE * (1 - EDGE_COSINE))
    return f0 + (1 - f0) / 21 - dip * edge * (1 - tint)
