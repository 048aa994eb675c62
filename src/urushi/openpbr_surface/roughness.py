"""From roughness and anisotropy to GGX widths, and indices of refraction of the interfaces."""

from typing import Any

import numpy as np

from urushi.checks import ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP


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


def base_index(
    specular_ior: Any,
    coat_ior: Any,
    coat_weight: Any,
    specular_weight: Any,
    xp: Any = np,
    *,
    inverted: bool = False,
) -> Any:
    """The index of the dielectric base relative to the medium above it.

    The ratio is specular_ior in air and specular_ior / coat_ior under the coat; partial coverage
    is linear in between. Below one, there is total reflection from above at grazing angles, which
    light refracted by a smooth coat does not reach directly. specular_weight then scales the
    reflectance at normal incidence, at most to 0.98.

    Args:
        specular_ior, coat_ior: indices of refraction, positive.
        coat_weight: in [0, 1].
        specular_weight: zero or more.
        xp: the module of the arrays' functions, NumPy or drjit.
        inverted: whether a ratio below one under the coat is replaced by its inverse, which
            reflects as much at normal incidence and nowhere totally. The specification recommends
            it where refraction by the coat is not followed.

    Returns:
        A positive ratio; 1 where the interface vanishes.

    Source: OpenPBR 1.1.1, Coat and Dielectric base (the ratio of the indices and its modulation).
    """
    covered = specular_ior / coat_ior
    if inverted:
        covered = xp.maximum(covered, coat_ior / specular_ior)
    ratio = specular_ior + coat_weight * (covered - specular_ior)
    amplitude = (ratio - 1) / (ratio + 1)  # the signed root of the reflectance
    # An amplitude of one would be an index without bound; the interfaces end far below.
    scaled = xp.clip(amplitude * xp.sqrt(specular_weight), -0.99, 0.99)
    return (1 + scaled) / (1 - scaled)


def interface_index(ratio: Any) -> np.ndarray:
    """A relative index within what the walk takes: in [0.5, 3], and a step away from one."""
    ratio = np.clip(np.asarray(ratio, np.float64), *ETA_RANGE)
    step = np.where(ratio < 1, -MIN_INDEX_STEP, MIN_INDEX_STEP)
    return np.where(np.abs(ratio - 1) < MIN_INDEX_STEP, 1 + step, ratio)
