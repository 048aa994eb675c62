"""From roughness and anisotropy to GGX widths, and indices of refraction of the interfaces."""

from typing import Any

import numpy as np

from urushi.checks import ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP

#: Least index of refraction of a medium.
LEAST_INDEX = 0.1


def widths(roughness: Any, anisotropy: Any, xp: Any = np) -> tuple[Any, Any]:
    """The GGX widths along the tangent and across it, as the specification defines them.

    Args:
        roughness, anisotropy: in [0, 1], numbers or arrays.
        xp: the module of the arrays' functions, NumPy or drjit.

    Returns:
        (alpha_t, alpha_b), zero or more; alpha_t may exceed one.

    Source: OpenPBR 1.1.1, Microfacet model: alpha_t^2 + alpha_b^2 = 2 roughness^4.
    """
    ratio = 1 - anisotropy
    along = roughness * roughness * xp.sqrt(2 / (1 + ratio * ratio))
    return along, ratio * along


def lobe_widths(roughness: Any, anisotropy: Any, xp: Any = np) -> tuple[Any, Any]:
    """`widths` within what the interfaces take, [0.01, 1]: a mirror has the narrowest lobe."""
    along, across = widths(roughness, anisotropy, xp)
    return tuple(xp.clip(width, MIN_ALPHA, 1) for width in (along, across))


def lobe_width(roughness: Any, xp: Any = np) -> Any:
    """`lobe_widths` of an isotropic surface, of which both are equal: roughness squared."""
    return xp.clip(roughness * roughness, MIN_ALPHA, 1)


def is_mirror(roughness: float) -> bool:
    """Whether an isotropic lobe of this roughness is narrower than the narrowest there is."""
    return roughness * roughness < MIN_ALPHA


def relative_index(ior: Any, coat_ior: Any, coat_weight: Any) -> Any:
    """An index of refraction relative to the medium above: air, the coat, or linear in between.

    Args:
        ior, coat_ior: indices of refraction, positive.
        coat_weight: in [0, 1].

    Source: OpenPBR 1.1.1, Coat (the ratio of the indices).
    """
    return ior + coat_weight * (ior / coat_ior - ior)


def modulated_index(ratio: Any, specular_weight: Any, xp: Any = np) -> Any:
    """The relative index whose reflectance at normal incidence is specular_weight times another's.

    Args:
        ratio: the other relative index, positive.
        specular_weight: zero or more.
        xp: the module of the arrays' functions, NumPy or drjit.

    Returns:
        A positive ratio, on the same side of one; 1 where the interface vanishes. The reflectance
        is at most 0.98.

    Source: OpenPBR 1.1.1, Dielectric base.
    """
    amplitude = (ratio - 1) / (ratio + 1)  # the signed root of the reflectance
    # An amplitude of one would be an index without bound; the interfaces end far below.
    scaled = xp.clip(amplitude * xp.sqrt(specular_weight), -0.99, 0.99)
    return (1 + scaled) / (1 - scaled)


def base_index(
    specular_ior: Any, coat_ior: Any, coat_weight: Any, specular_weight: Any, xp: Any = np
) -> Any:
    """The index of the dielectric base relative to the medium above it.

    Below one, there is total reflection from above at grazing angles, which light refracted by a
    smooth coat does not reach directly. The specification recommends the inverse ratio where
    refraction by the coat is not followed; here it is.

    The arguments are those of `relative_index` and `modulated_index`.
    """
    ratio = relative_index(specular_ior, coat_ior, coat_weight)
    return modulated_index(ratio, specular_weight, xp)


def interface_index(ratio: Any, xp: Any = np) -> Any:
    """A relative index within what the walk takes: in [0.5, 3], and a step away from one."""
    ratio = xp.clip(ratio, *ETA_RANGE)
    # Of single precision, whose 1.001 is a little less than the step away from one.
    step = MIN_INDEX_STEP + 1e-7
    where = xp.where if xp is np else xp.select
    return where(xp.abs(ratio - 1) < step, where(ratio < 1, 1 - step, 1 + step), ratio)
