"""Roughness and darkening of a base under a rough coat: fits to light transport. NumPy only.

Roughness r is OpenPBR's: GGX of width r^2. `coat`, `base`: roughness of both, up to 1; `eta`: index
of the coat over that of the medium above, from 1 to 3. Numbers or arrays. In the public domain.
"""

import numpy as np


def base_roughness_inside(eta, coat, base, size=1.36, power=0.59, limit=4.05):
    """Roughness of the base's lobe for half vectors of the refracted directions."""
    alpha = coat**2
    blur = size * (1 - 1 / eta) ** power * alpha / (1 + limit * alpha)  # by two refractions
    return np.hypot(base**2, blur) ** 0.5


def base_roughness(eta, coat, base, size=0.86, power=0.53, limit=2.37, rise=1.59, bend=0.87):
    """The same for half vectors of the directions outside: what a lobe of the base is given."""
    alpha, wider = base_roughness_inside(eta, coat, base, size, power, limit) ** 2, eta**rise
    return (wider * alpha / (1 + ((wider - 1) * alpha) ** bend) ** (1 / bend)) ** 0.5


def internal_reflection(eta, base, diffuse=None, size=1.56, power=1.82):
    """K: share of the light from a metal, of a roughness, that the coat returns to it.

    diffuse: the share of diffuse light; None: that of a smooth coat.
    """
    r = (eta - 1) / (eta + 1)
    if diffuse is None:
        mean = r * (0.64 + r * (2.75 + r * 2.16)) / (1 + r * (9.97 - r * 5.42))  # of Fresnel's term
        diffuse = 1 - (1 - mean) / eta**2
    return np.minimum(r * r + (diffuse - r * r) * size * base**power, 0.99)


def darkening(internal, albedo):
    """Delta: factor of the base's light for reflections inside the coat (OpenPBR, 3.4.1).

    albedo: of the base at normal incidence.
    """
    return (1 - internal) / (1 - internal * albedo)
