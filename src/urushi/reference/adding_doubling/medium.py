"""A homogeneous Henyey-Greenstein slab by doubling (van de Hulst 1980, chapter 4)."""

import numpy as np

from urushi.reference.adding_doubling.quadrature import Grid

#: Optical depth of the first layer. Its light scattered twice is left out: an error of this order.
_THIN = 2e-8

#: Modes of the phase function below this are dropped: g**m bounds mode m.
_NEGLIGIBLE = 1e-9


def slab(grid: Grid, albedo: float, sigma_t: float, g: float) -> tuple[np.ndarray, np.ndarray]:
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


def direct(grid: Grid, sigma_t: float) -> np.ndarray:
    """Unscattered transmission exp(-sigma_t / mu) of the nodes, (N,)."""
    return np.exp(-sigma_t / grid.mu)


def _phase_modes(grid: Grid, g: float) -> tuple[np.ndarray, np.ndarray]:
    """Modes (K, N, N) of the phase function, to the same and to the other hemisphere [1/sr].

    From Legendre's addition theorem, with degrees up to 2 N - 1, for which Gauss's quadrature of
    each hemisphere is exact: the phase function is then normalised to rounding, for any g.
    """
    degrees = 2 * len(grid.mu)
    kept = 1 if g == 0 else 1 + int(np.log(_NEGLIGIBLE) / np.log(abs(g)))
    forward, backward = [], []
    for m in range(min(grid.modes, kept, degrees)):
        legendre = _associated_legendre(m, degrees, grid.mu)
        degree = np.arange(m, degrees)
        moment = (2 * degree + 1) / (4 * np.pi) * float(g) ** degree
        mirrored = moment * (-1.0) ** (degree + m)
        forward.append((legendre.T * moment) @ legendre)
        backward.append((legendre.T * mirrored) @ legendre)
    return np.stack(forward), np.stack(backward)


def _associated_legendre(m: int, degrees: int, mu: np.ndarray) -> np.ndarray:
    """sqrt((l - m)! / (l + m)!) P_l^m(mu) for l = m to degrees - 1, by recurrence."""
    rows = np.zeros((degrees - m, len(mu)))
    order = np.arange(1, m + 1)
    rows[0] = np.prod(np.sqrt((2 * order - 1) / (2 * order))) * (1 - mu**2) ** (m / 2)
    if degrees - m > 1:
        rows[1] = np.sqrt(2 * m + 1) * mu * rows[0]
    for n in range(2, degrees - m):
        deg = m + n
        rows[n] = (2 * deg - 1) * mu * rows[n - 1] - np.sqrt((deg - 1) ** 2 - m**2) * rows[n - 2]
        rows[n] /= np.sqrt(deg**2 - m**2)
    return rows
