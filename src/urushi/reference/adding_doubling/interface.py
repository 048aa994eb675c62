"""Operators of a rough dielectric interface whose kernels the nodes of a medium cannot resolve.

Transmission is narrow for a smooth interface or one of small eta, and for a rough one it jumps
where the microfacet normal crosses the horizon; inner reflection has the root of Fresnel's formula
at the critical angle. Each direction therefore gets its own composite Gauss quadrature, graded
about the lobe and split at the fault; only the field inside is interpolated (product integration).
"""

import numpy as np

from urushi.reference.adding_doubling import surfaces
from urushi.reference.adding_doubling.quadrature import Grid, azimuths, graded, project


def transmission(grid: Grid, mu_out: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """Modes (M, A, N) of the symmetric kernel S from (A,) outside cosines to the nodes inside."""
    mu_t = np.sqrt(1 - (1 - mu_out**2) / eta**2)
    # Tilting the microfacet by d turns the refracted direction by d (1 - cos_i / (eta cos_t)).
    width = alpha * np.maximum(1 - 1 / eta, 1 - mu_out / (eta * mu_t))
    # The normal -(out + eta in) is level where mu_out = eta mu_in.
    fine = graded(np.arccos(mu_t), width, np.arccos(mu_out / eta))
    intervals = azimuths(alpha * (1 - 1 / eta))
    return project(grid, surfaces.transmission(alpha, eta), mu_out, fine, intervals)


def inner_reflection(grid: Grid, alpha: float, eta: float) -> np.ndarray:
    """Reflection on the side of the larger index between the nodes, (M, N, N), weighted."""
    theta, critical = np.arccos(grid.mu), np.arcsin(1 / eta)
    # In the plane of incidence, facets half way to this border are met at the critical angle.
    fine = graded(theta, np.full_like(theta, 2 * alpha), 2 * critical - theta)
    kernel = surfaces.inner_reflection(alpha, eta)
    # In azimuth the lobe narrows towards grazing; at a fifth of its width the flux is negligible.
    rows = grid.root[:, None] * project(grid, kernel, grid.mu, fine, azimuths(alpha / 5))
    return (rows + np.swapaxes(rows, 1, 2)) / 2  # reciprocal, but for the error of the rows
