"""Quadrature over a hemisphere, and azimuthal Fourier modes of scattering kernels.

A kernel k(mu, mu', phi) [1/sr], with phi the azimuth between the two directions of *propagation*
(so that a mirror has phi = 0), is the series sum over m of (2 - [m = 0]) k_m(mu, mu') cos(m phi).
Operators compose as k_m W l_m with W = diag(2 pi mu w); this package stores sqrt(W) k_m sqrt(W), so
that they compose as plain matrices and are symmetric where the kernel is reciprocal (van de Hulst,
Multiple Light Scattering, 1980, chapter 4; Jakob et al. 2014, section 4).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct
from scipy.interpolate import BarycentricInterpolator

#: A kernel (mu_out, mu_in, cos(phi)) -> [1/sr], broadcasting its three arguments.
Kernel = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]

#: Largest number of kernel values in memory; bounds it to a few hundred megabytes.
_CHUNK = 1 << 20

#: Gauss points in each panel of polar angle of a graded quadrature.
_POINTS = 10

#: Panel borders at these multiples of a lobe's half width from its centre.
_GRADING = np.array([-24, -6, -1.5, 1.5, 6, 24])

#: Intervals of azimuth times the least half width of a lobe; the error is about exp(-2 x this).
_AZIMUTHS = 6.0


@dataclass(frozen=True)
class CosineGrid:
    """Directions of one medium and the modes kept.

    Attributes:
        mu: (N,) Gauss-Legendre cosines in (0, 1), increasing.
        root: (N,) sqrt(2 pi mu w), the root of the weight of projected solid angle.
        modes: number M of Fourier modes, m = 0 to M - 1.
    """

    mu: np.ndarray
    root: np.ndarray
    modes: int

    @staticmethod
    def gauss(nodes: int, modes: int) -> "CosineGrid":
        """Gauss-Legendre quadrature of `nodes` cosines; their weights sum to pi."""
        x, w = np.polynomial.legendre.leggauss(nodes)
        mu = 0.5 * (1 + x)
        return CosineGrid(mu, np.sqrt(np.pi * mu * w), modes)

    def operator(self, kernel: Kernel) -> np.ndarray:
        """The kernel between the nodes of this grid: (M, N, N), weighted on both sides."""
        return fourier(kernel, self.mu, self.mu, self.modes) * np.outer(self.root, self.root)


def fourier(
    kernel: Kernel, mu_out: np.ndarray, mu_in: np.ndarray, modes: int, intervals: int = 0
) -> np.ndarray:
    """Fourier modes (M, A, B) of a kernel that is even in phi.

    The trapezium rule on at least 4 M intervals of [0, pi] converges faster than any power for a
    smooth kernel, and aliases no mode below 7 M on the M kept.

    Args:
        mu_out: (A,) cosines.
        mu_in: (B,) cosines, or (A, B), different for each outgoing one.
        intervals: least number of intervals.
    """
    intervals = max(4 * modes, intervals)
    cosines = np.cos(np.linspace(0, np.pi, intervals + 1))
    mu_in = np.broadcast_to(mu_in, (len(mu_out), mu_in.shape[-1]))
    rows = max(1, _CHUNK // (mu_in.shape[-1] * len(cosines)))
    parts = []
    for r in range(0, len(mu_out), rows):
        values = kernel(mu_out[r : r + rows, None, None], mu_in[r : r + rows, :, None], cosines)
        parts.append(dct(values, type=1)[..., :modes].copy())
    return np.moveaxis(np.concatenate(parts), -1, 0) / (2 * intervals)


def azimuths(width: float) -> int:
    """Intervals of [0, pi] that resolve a lobe of this half width in azimuth, radians."""
    return int(_AZIMUTHS / width)


def graded(
    centre: np.ndarray, width: np.ndarray, border: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Composite Gauss quadratures of the cosine over the hemisphere, one for each lobe.

    Args:
        centre, width: (A,) polar angle and half width of the lobe, radians.
        border: (A,) polar angle of a further panel border, where the integrand jumps.

    Returns:
        cosines (A, Q) and their weights, which sum to 1.
    """
    lobe = centre[:, None] + width[:, None] * _GRADING
    ends = np.broadcast_to([0, np.pi / 2], (len(centre), 2))
    borders = np.concatenate([ends, lobe, border[:, None]], axis=1)
    borders = np.sort(np.clip(borders, 0, np.pi / 2), axis=1)
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    middle, half = (borders[:, 1:] + borders[:, :-1]) / 2, np.diff(borders) / 2
    theta = (middle[..., None] + half[..., None] * x).reshape(len(centre), -1)
    weight = (half[..., None] * w).reshape(len(centre), -1)
    return np.cos(theta), np.sin(theta) * weight


def interpolation(grid: CosineGrid, mu: np.ndarray) -> np.ndarray:
    """Lagrange polynomials of the nodes at `mu`, any shape: (..., N)."""
    return BarycentricInterpolator(grid.mu, np.eye(len(grid.mu)), rng=0)(mu)


def project(
    grid: CosineGrid,
    kernel: Kernel,
    mu_out: np.ndarray,
    fine: tuple[np.ndarray, np.ndarray],
    intervals: int = 0,
) -> np.ndarray:
    """Modes (M, A, N) of a kernel from (A,) cosines to the nodes, by product integration.

    Applied to a radiance g at the nodes, weighted as root * g, the result is the integral of
    kernel g mu. The kernel is integrated on the quadratures `fine` (cosines and weights, (A, Q)
    each, see `graded`); only the smooth g is interpolated between the nodes.
    """
    mu, weight = fine
    modes = fourier(kernel, mu_out, mu, grid.modes, intervals) * (2 * np.pi * mu * weight)
    basis = interpolation(grid, mu) / grid.root
    return np.moveaxis(np.moveaxis(modes, 0, 1) @ basis, 1, 0)


def series(modes: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Sum the Fourier series: modes (M, P) at the azimuths phi (P,), radians -> (P,)."""
    order = np.arange(len(modes))
    factor = np.where(order == 0, 1.0, 2.0)[:, None] * np.cos(order[:, None] * phi)
    return (factor * modes).sum(0)
