"""The darkening of the base by reflections inside the coat, and its removal.

Only the factor that cancels the darkening is an approximation. The darkening itself results from
the light transport between the layers.
"""

from typing import Any, NamedTuple

import numpy as np

from urushi.openpbr.glossy import internal_reflectance


class Base(NamedTuple):
    """What the estimate needs of the base.

    Attributes:
        albedo: directional albedo at normal incidence, per channel.
        roughness: specular_roughness.
        metalness: base_metalness.
        reflectance: of the dielectric base's interface at normal incidence.
    """

    albedo: Any
    roughness: Any
    metalness: Any
    reflectance: Any


def mean_fresnel(eta: Any, xp: Any = np) -> Any:
    """Cosine-weighted mean of the Fresnel reflectance of a smooth dielectric.

    eta: index relative to the medium of the light, at least 1.

    Source: Kulla and Conty 2017, a fit, within 0.1 % of one.
    """
    return xp.log((10893 * eta - 1438.2) / (-774.4 * eta * eta + 10212 * eta + 1))


def internal(coat_eta: Any, base: Base, xp: Any = np) -> Any:
    """Share of the light leaving the base that the coat's interface returns to it, K.

    Between that of diffuse light and that of light along the normal, by the roughness of the base.

    Source: OpenPBR 1.1.1, Coat darkening.
    """
    diffuse = internal_reflectance(1 - mean_fresnel(coat_eta, xp), coat_eta)
    root = (coat_eta - 1) / (coat_eta + 1)
    dielectric = 1 + (base.roughness - 1) * base.reflectance
    rough = dielectric + (base.roughness - dielectric) * base.metalness
    return root * root + (diffuse - root * root) * rough


def boost(darkening: Any, coat_eta: Any, base: Base, xp: Any = np) -> Any:
    """The factor of the base's BRDF under the coat for a given coat_darkening.

    It is one for a darkening of one. For zero it is the B0 for which the coated albedo at normal
    incidence is that without darkening, F0 + (1 - F0) E_b: the base's albedo becomes
    E_b / (1 - K + K E_b), which never exceeds one.

    Args:
        darkening: coat_darkening, in [0, 1].
        coat_eta: index of the coat, relative to air.
        base: see `Base`.
        xp: the module of the arrays' functions, NumPy or drjit.

    Returns:
        Per channel, at least one.

    Source: OpenPBR 1.1.1, Coat darkening: Delta = (1 - K) / (1 - B E_b K) with B Delta = 1.
    """
    k = internal(coat_eta, base, xp)
    undarkened = 1 / (1 - k + k * base.albedo)
    return 1 + (undarkened - 1) * (1 - darkening)
