"""Slabs of a Henyey-Greenstein medium without interfaces, by doubling (van de Hulst 1980, ch. 4).

Light in azimuth is a series: the sum over m of (2 - [m = 0]) k_m(mu, mu') cos(m phi), with phi
between the two directions of *propagation*, so that a mirror has phi = 0. Operators compose as
k_m W l_m with W = diag(2 pi mu w); here sqrt(W) k_m sqrt(W) is stored, so that they compose as
plain matrices and are symmetric.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.special import assoc_legendre_p_all

#: Optical depth of the first layer. Double scattering in it is neglected, an error of this order.
_THIN = 2e-8

#: Modes of the phase function below this are dropped: g**m bounds mode m.
_NEGLIGIBLE = 1e-9


@dataclass(frozen=True)
class CosineGrid:
    """Directions of a medium and the modes kept.

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

    def interpolation(self, mu: np.ndarray) -> np.ndarray:
        """Lagrange polynomials of the nodes at `mu`, any shape: (..., N)."""
        return BarycentricInterpolator(self.mu, np.eye(len(self.mu)), rng=0)(mu)


def series(modes: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Sum the Fourier series: modes (M, P) at the azimuths phi (P,), radians -> (P,)."""
    order = np.arange(len(modes))
    factor = np.where(order == 0, 1.0, 2.0)[:, None] * np.cos(order[:, None] * phi)
    return (factor * modes).sum(0)


def slab(
    grid: CosineGrid, albedo: float, sigma_t: float, g: float
) -> tuple[np.ndarray, np.ndarray]:
    """Weighted reflection and transmission of a slab of optical depth `sigma_t`.

    Returns:
        reflection, transmission: (K, N, N) for the K <= M modes that scatter (at least one); the
        transmission includes the unscattered light on its diagonal. The modes that are left out
        reflect nothing and transmit `direct(grid, sigma_t)`.
    """
    doublings = max(0, int(np.ceil(np.log2(max(sigma_t, _THIN) / _THIN))))
    thin = sigma_t / 2**doublings
    forward, backward = _phase_modes(grid, g)
    mu, weight = grid.mu, np.outer(grid.root, grid.root)
    sum_inv = 1 / mu[:, None] + 1 / mu
    reflection = albedo * backward * weight * -np.expm1(-thin * sum_inv) / np.add.outer(mu, mu)
    # (exp(-t/a) - exp(-t/b)) / (a - b) without cancellation, the diagonal being its limit.
    gap = thin * (1 / mu[:, None] - 1 / mu)
    slope = np.where(np.abs(gap) > 1e-12, -np.expm1(-gap) / np.where(gap == 0, 1, gap), 1.0)
    path = np.exp(-thin / mu) * slope * thin / np.outer(mu, mu)
    transmission = albedo * forward * weight * path + np.diag(np.exp(-thin / mu))
    identity = np.eye(len(mu))
    for _ in range(doublings):
        between = np.linalg.solve(identity - reflection @ reflection, transmission)
        reflection = reflection + transmission @ reflection @ between
        transmission = transmission @ between
    return reflection, transmission


def direct(grid: CosineGrid, sigma_t: float) -> np.ndarray:
    """Unscattered transmission exp(-sigma_t / mu) of the nodes, (N,)."""
    return np.exp(-sigma_t / grid.mu)


def _phase_modes(grid: CosineGrid, g: float) -> tuple[np.ndarray, np.ndarray]:
    """Modes (K, N, N) of the phase function, to the same and to the other hemisphere [1/sr].

    From Legendre's addition theorem, with degrees up to 2 N - 1, for which Gauss's quadrature of
    each hemisphere is exact: the phase function is then normalised to rounding, for any g.
    """
    degree = np.arange(2 * len(grid.mu))
    kept = 1 if g == 0 else 1 + int(np.log(_NEGLIGIBLE) / np.log(abs(g)))
    order = np.arange(min(grid.modes, kept, len(degree)))
    # Normalised by sqrt((2 l + 1) / 2 (l - m)! / (l + m)!): (L, M, N).
    legendre = assoc_legendre_p_all(degree[-1], order[-1], grid.mu, norm=True)[0, :, : len(order)]
    moment = float(g) ** degree[:, None] / (2 * np.pi)
    signs = 1, (-1.0) ** (degree[:, None] + order)  # to the other hemisphere
    forward, backward = (
        np.einsum("lm,lmi,lmj->mij", moment * sign, legendre, legendre, optimize=True)
        for sign in signs
    )
    return forward, backward
