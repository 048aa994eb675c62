"""Operators of the layers: media by doubling, rough interfaces, and their addition to a reflector.

All operators are (M, N, N), weighted on both sides (see quadrature.py), seen from above. A slab of
a Henyey-Greenstein medium is doubled (van de Hulst 1980, chapter 4).

Nodes must resolve the lobes of an interface, whose half width is about alpha |1 - 1 / eta| in
transmission, and Fresnel's root at the critical angle, whose error falls with their square.
"""

import numpy as np
from scipy.special import assoc_legendre_p_all
from tests.oracles.adding_doubling import surfaces
from tests.oracles.adding_doubling.quadrature import CosineGrid, fourier

#: Optical depth of the first layer. Double scattering in it is neglected, an error of this order.
_THIN = 2e-8

#: Modes of the phase function below this are dropped: g**m bounds mode m.
_NEGLIGIBLE = 1e-9


def under_medium(
    grid: CosineGrid, reflector: np.ndarray, albedo: float, sigma_t: float, g: float
) -> np.ndarray:
    """Reflection R + T A (1 - R A)^-1 T of a slab (R, T) over the reflector A."""
    straight = direct(grid, sigma_t)
    result = straight[:, None] * reflector * straight
    if sigma_t == 0 or albedo == 0:
        return result
    reflect, transmit = slab(grid, albedo, sigma_t, g)
    bottom = reflector[: len(reflect)]
    between = np.linalg.solve(np.eye(len(grid.mu)) - reflect @ bottom, transmit)
    result[: len(reflect)] = reflect + transmit @ bottom @ between
    return result


def trapped(grid: CosineGrid, reflector: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """All bounces A (1 - I A)^-1 between the reflector A and the inner side I of an interface."""
    inner = grid.operator(surfaces.inner_reflection(alpha, eta))
    system = np.eye(len(grid.mu)) - reflector @ inner
    return np.linalg.solve(system, reflector)


def under_interface(
    grid: CosineGrid, reflector: np.ndarray, alpha: float, eta: float
) -> np.ndarray:
    """Reflection of a rough interface over the reflector, between the nodes of the medium above."""
    outer = grid.operator(surfaces.outer_reflection(alpha, eta))
    # The flux is conserved by eta**2 S inwards and S outwards.
    through = grid.root[:, None] * transmission(grid, grid.mu, alpha, eta)
    bounces = trapped(grid, reflector, alpha, eta)
    return outer + eta**2 * through @ bounces @ np.swapaxes(through, 1, 2)


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


def transmission(grid: CosineGrid, mu_out: np.ndarray, alpha: float, eta: float) -> np.ndarray:
    """Modes (M, A, N) of the symmetric kernel S from (A,) outside cosines to the nodes inside."""
    return fourier(surfaces.transmission(alpha, eta), mu_out, grid.mu, grid.modes) * grid.root
