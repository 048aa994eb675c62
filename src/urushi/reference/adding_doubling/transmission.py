"""Transmission of a rough interface, from given outside cosines to the nodes of the medium inside.

The kernel is narrow for a smooth interface or one of small eta, and for a rough one it jumps where
the microfacet normal crosses the horizon. Neither can be left to the nodes of the medium: each
outside direction gets its own composite Gauss quadrature, graded about the refracted direction and
split at the jump; only the smooth field inside is interpolated between the nodes (product
integration).
"""

import numpy as np

from urushi.reference.adding_doubling import surfaces
from urushi.reference.adding_doubling.quadrature import (
    Grid,
    azimuths,
    fourier,
    graded,
    interpolation,
)


def project(grid: Grid, mu_out: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """Modes (M, A, N) of the symmetric kernel S from (A,) outside cosines, weighted inside.

    On a radiance g at the nodes, weighted as root * g, it gives the integral of S g mu.
    """
    mu, weight = _fine(mu_out, alpha, eta)
    intervals = azimuths(alpha * (1 - 1 / eta))
    kernel = surfaces.transmission(alpha, eta)
    modes = fourier(kernel, mu_out, mu, grid.modes, intervals) * (2 * np.pi * mu * weight)
    basis = interpolation(grid, mu) / grid.root
    return np.moveaxis(np.moveaxis(modes, 0, 1) @ basis, 1, 0)


def _fine(mu_out: np.ndarray, alpha: float, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """Cosines inside and their weights, (A, Q) each, for the outside cosines (A,)."""
    mu_t = np.sqrt(1 - (1 - mu_out**2) / eta**2)
    # Tilting the microfacet by d turns the refracted direction by d (1 - cos_i / (eta cos_t)).
    width = alpha * np.maximum(1 - 1 / eta, 1 - mu_out / (eta * mu_t))
    return graded(np.arccos(mu_t), width, np.arccos(mu_out / eta))
