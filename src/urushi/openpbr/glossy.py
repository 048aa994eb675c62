"""The glossy-diffuse base: a dielectric interface over a diffuse slab, in closed form.

The reflection of a diffuse slab does not depend on the direction of incidence. If the interface
conserves energy and E(w) is its directional reflectance, the fraction 1 - E(w) of the light is
transmitted; the light that leaves follows by reciprocity. All orders of reflection between both
form a geometric series.
"""

from typing import Any


def internal_reflectance(passed_mean: Any, eta: Any) -> Any:
    """Share of diffuse light from below that the interface reflects down again.

    Args:
        passed_mean: the cosine-weighted mean of 1 - E over the hemisphere above.
        eta: index of the slab relative to the medium above.

    Returns:
        1 - passed_mean / eta^2, in [0, 1) for an interface that conserves energy.

    Source: reciprocity of the transmitted radiance; for smooth interfaces Elias and Elias 2001.
    """
    return 1 - passed_mean / (eta * eta)


def slab_albedo(color: Any, internal: Any) -> Any:
    """The albedo of the diffuse slab that gives the base the colour base_color.

    The specification defines base_color as the share of the transmitted light that leaves again,
    at normal incidence: (1 - internal) rho / (1 - rho internal) = color.

    Args:
        color: base_weight times base_color, in [0, 1].
        internal: of `internal_reflectance`.

    Returns:
        rho, in [0, 1], at least `color`.

    Source: OpenPBR 1.1.1, Glossy-diffuse (its constraint of the albedo), solved for rho.
    """
    return color / (1 - internal + color * internal)


def promised(rho: Any, internal: Any) -> Any:
    """The inverse of `slab_albedo`: the share of the transmitted light that leaves again."""
    return (1 - internal) * rho / (1 - rho * internal)
