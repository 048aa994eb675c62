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

#: Intervals of azimuth between 0 and pi, which resolve a lobe of a half width of 0.05 radians.
_INTERVALS = 192


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


def fourier(kernel: Kernel, mu_out: np.ndarray, mu_in: np.ndarray, modes: int) -> np.ndarray:
    """Fourier modes (M, A, B) of a kernel that is even in phi, from (B,) to (A,) cosines.

    The trapezium rule converges faster than any power for a smooth kernel.
    """
    cosines = np.cos(np.linspace(0, np.pi, _INTERVALS + 1))
    values = kernel(mu_out[:, None, None], mu_in[:, None], cosines)
    return np.moveaxis(dct(values, type=1)[..., :modes], -1, 0) / (2 * _INTERVALS)


def interpolation(grid: CosineGrid, mu: np.ndarray) -> np.ndarray:
    """Lagrange polynomials of the nodes at `mu`, any shape: (..., N)."""
    return BarycentricInterpolator(grid.mu, np.eye(len(grid.mu)), rng=0)(mu)


def series(modes: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Sum the Fourier series: modes (M, P) at the azimuths phi (P,), radians -> (P,)."""
    order = np.arange(len(modes))
    factor = np.where(order == 0, 1.0, 2.0)[:, None] * np.cos(order[:, None] * phi)
    return (factor * modes).sum(0)
