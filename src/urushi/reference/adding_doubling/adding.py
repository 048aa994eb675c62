"""Adding: what a reflector becomes under a medium and under a rough interface.

All operators are (M, N, N), weighted on both sides (see quadrature.py), seen from above.
"""

import numpy as np

from urushi.reference.adding_doubling import interface, medium, surfaces
from urushi.reference.adding_doubling.quadrature import Grid


def under_medium(
    grid: Grid, reflector: np.ndarray, albedo: float, sigma_t: float, g: float
) -> np.ndarray:
    """Reflection R + T A (1 - R A)^-1 T of a slab (R, T) over the reflector A."""
    straight = medium.direct(grid, sigma_t)
    result = straight[:, None] * reflector * straight
    if sigma_t == 0 or albedo == 0:
        return result
    reflect, transmit = medium.slab(grid, albedo, sigma_t, g)
    bottom = reflector[: len(reflect)]
    between = np.linalg.solve(np.eye(len(grid.mu)) - reflect @ bottom, transmit)
    result[: len(reflect)] = reflect + transmit @ bottom @ between
    return result


def trapped(grid: Grid, reflector: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """All bounces A (1 - I A)^-1 between the reflector A and the inner side I of an interface."""
    inner = interface.inner_reflection(grid, alpha, eta)
    system = np.eye(len(grid.mu)) - reflector @ inner
    return np.linalg.solve(system, reflector)


def under_interface(grid: Grid, reflector: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """Reflection of a rough interface over the reflector, between the nodes of the medium above."""
    outer = grid.operator(surfaces.outer_reflection(alpha, eta))
    # The flux is conserved by eta**2 S inwards and S outwards.
    through = grid.root[:, None] * interface.transmission(grid, grid.mu, alpha, eta)
    bounces = trapped(grid, reflector, alpha, eta)
    return outer + eta**2 * through @ bounces @ np.swapaxes(through, 1, 2)
