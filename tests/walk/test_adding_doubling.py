"""The adding-doubling solver: exact limits, conservation, convergence, and two other methods."""

import numpy as np
import pytest
from tests.oracles import adding_doubling
from tests.oracles.adding_doubling import layers, surfaces
from tests.oracles.adding_doubling.quadrature import CosineGrid, series

from urushi.walk import coat, conductor, dielectric, diffuse, simulate

pytestmark = pytest.mark.slow  # of an oracle of the tests alone


def directions(count: int, seed: int) -> np.ndarray:
    """Cosine-distributed unit vectors with cosines above 0.05."""
    rng = np.random.default_rng(seed)
    u, v = 0.0025 + 0.9975 * rng.random(count), 2 * np.pi * rng.random(count)
    sin = np.sqrt(1 - u)
    return np.stack([sin * np.cos(v), sin * np.sin(v), np.sqrt(u)], axis=1)


ONE_COAT = coat(conductor(0.3, (0.9, 0.5, 0.2)), 0.2, 1.5, (0.9, 0.99, 0.5), 1.0, g=0.5)
TWO_COATS = coat(
    coat(conductor(0.3, 0.8), 0.4, 1.3, 0.9, (2.0, 0.5, 0.0), g=0.5),
    *(0.25, 1.4, (0.95, 0.8, 1.0), (0.5, 3.0, 1.0)),
    g=-0.5,
)
DIFFUSE = coat(diffuse((0.8, 0.5, 0.1)), 0.3, 1.6, 0.99, (8.0, 1.0, 3.0), g=(0.9, -0.8, 0.0))
# Media of a lower index than what is above them: under the surface, and under another coat.
BELOW = coat(conductor(0.3, (0.9, 0.5, 0.2)), 0.25, 0.7, 0.9, (1.0, 0.3, 3.0), g=0.3)
INSIDE = coat(coat(diffuse(0.8), 0.3, 0.8, 0.95, (1.0, 0.3, 2.0), g=0.5), 0.25, 1.5, 0.9, 0.5)
STACKS = {
    "conductor": ONE_COAT,
    "two coats": TWO_COATS,
    "diffuse": DIFFUSE,
    "thinner medium": BELOW,
    "thinner medium inside": INSIDE,
    "complex index": coat(conductor(0.4, eta=0.2, k=3.0), 0.3, 1.4, 0.5, 0.5),
    "dielectric": coat(dielectric(0.4, 1.7), 0.3, 1.4, 0.5, 0.5),
}


@pytest.mark.parametrize("g", [0.0, 0.5, -0.5, 0.9])
def test_fourier_modes_sum_to_the_phase_function(g: float) -> None:
    grid = CosineGrid.gauss(nodes=64, modes=128)
    forward, backward = layers._phase_modes(grid, g)
    phi = 0.7
    sines = np.sqrt(1 - grid.mu**2)
    for modes, sign in ((forward, 1), (backward, -1)):
        cos = sign * np.outer(grid.mu, grid.mu) + np.outer(sines, sines) * np.cos(phi)
        exact = (1 - g**2) / (4 * np.pi * (1 + g**2 - 2 * g * cos) ** 1.5)
        value = series(modes.reshape(len(modes), -1), np.float64(phi)).reshape(cos.shape)
        # Modes above degree 128 are left out: 0.9^128 * 128 of the peak.
        np.testing.assert_allclose(value, exact, atol=1e-6 if abs(g) < 0.9 else 5e-3)


@pytest.mark.parametrize("g", [0.0, 0.5, -0.5, 0.9])
@pytest.mark.parametrize("sigma_t", [0.05, 1.0, 8.0])
def test_a_white_medium_conserves_energy(g: float, sigma_t: float) -> None:
    grid = CosineGrid.gauss(nodes=24, modes=1)
    reflect, transmit = layers.slab(grid, albedo=1.0, sigma_t=sigma_t, g=g)
    # Under uniform radiance from above, all of its flux leaves on the two sides.
    np.testing.assert_allclose((reflect[0] + transmit[0]) @ grid.root, grid.root, rtol=2e-6)


@pytest.mark.parametrize("albedo", [0.5, 0.9, 0.99])
def test_half_space_is_chandrasekhars(albedo: float) -> None:
    grid = CosineGrid.gauss(nodes=32, modes=1)
    reflect = layers.slab(grid, albedo=albedo, sigma_t=200.0, g=0.0)[0][0]
    h = np.ones_like(grid.mu)
    kernel = grid.root**2 / (2 * np.pi) / np.add.outer(grid.mu, grid.mu)
    for _ in range(500):  # Chandrasekhar 1960, chapter V, solved for 1 / H
        h = 1 / (np.sqrt(1 - albedo) + 0.5 * albedo * (kernel @ h))
    f = albedo / (4 * np.pi) * np.outer(h, h) / np.add.outer(grid.mu, grid.mu)
    # The discrete H solves the discrete equations exactly, except for the thin first layer.
    np.testing.assert_allclose(reflect / np.outer(grid.root, grid.root), f, rtol=1e-5)


@pytest.mark.parametrize(
    ("alpha", "eta"),
    [(0.15, 1.5), (0.5, 1.1), (0.9, 2.0), (0.15, 0.7), (0.5, 0.95), (0.9, 0.5)],
)
def test_transmittance_of_the_interface_is_that_of_microfacets(alpha: float, eta: float) -> None:
    """Fourier modes and graded quadrature against a sum over microfacet normals."""
    cos_i = np.array([0.2, 0.6, 0.95])
    grid = CosineGrid.gauss(nodes=24, modes=2)
    passed = eta**2 * layers.transmission(grid, cos_i, alpha, eta)[0] @ grid.root
    expected = [microfacet_transmittance(c, alpha, eta) for c in cos_i]
    np.testing.assert_allclose(passed, expected, rtol=2e-3)


def microfacet_transmittance(cos_i: float, alpha: float, eta: float) -> float:
    """Flux through a rough interface: visible normals, (1 - F), and masking of the refracted."""
    x, weight = np.polynomial.legendre.leggauss(400)
    theta_m, weight = np.pi / 4 * (1 + x[:, None]), np.pi / 4 * weight[:, None]
    cos_m, sin_m, sin_i = np.cos(theta_m), np.sin(theta_m), np.sqrt(1 - cos_i**2)
    phi = 2 * np.pi * (np.arange(400) + 0.5) / 400
    dot = np.maximum(sin_i * sin_m * np.cos(phi) + cos_i * cos_m, 0)
    cos_t = np.sqrt(np.maximum(1 - (1 - dot**2) / eta**2, 0.0))
    z = (dot / eta - cos_t) * cos_m - cos_i / eta  # z of the refracted direction
    masked = surfaces._smith(np.clip(-z, 1e-9, 1), alpha) * surfaces._smith(cos_i, alpha) * (z < 0)
    flux = (1 - surfaces.fresnel_dielectric(dot, eta)) * masked * dot / cos_i
    return float((surfaces._ggx(cos_m**2, alpha) * flux * sin_m * weight).sum() * 2 * np.pi / 400)


def test_white_furnace_loses_only_the_energy_of_single_scattering() -> None:
    cos = np.array([0.1, 0.5, 1.0])
    albedo = np.stack(
        [
            adding_doubling.albedo(coat(diffuse(1.0), alpha, 1.5, 1.0, 1.0, g=0.3), cos)[:, 0]
            for alpha in (0.6, 0.3, 0.1, 0.05)
        ]
    )
    assert np.all(np.diff(albedo, axis=0) > 0)  # smoother loses less
    assert np.all(albedo < 1)
    # The loss vanishes with the width: a third of the width has a third of the loss.
    assert np.all(1 - albedo[2] < 0.5 * (1 - albedo[1]))
    assert np.all(albedo[-1, 1:] > 0.97)


def test_reciprocity() -> None:
    wi, wo = directions(20, 1), directions(20, 2)
    for stack in STACKS.values():
        forth = adding_doubling.solve(stack, wi, wo, nodes=24, modes=24)
        back = adding_doubling.solve(stack, wo, wi, nodes=24, modes=24)
        np.testing.assert_allclose(forth, back, rtol=1e-6)  # up to the thin layer


def test_converges_with_nodes_and_modes() -> None:
    wi, wo = directions(60, 3), directions(60, 4)
    stack = coat(conductor(0.15, 0.9), 0.15, 1.5, 0.95, 1.0, g=0.5)
    best = adding_doubling.solve(stack, wi, wo, nodes=64, modes=64)[:, 0]
    error = [
        np.abs(adding_doubling.solve(stack, wi, wo, nodes=n, modes=n)[:, 0] / best - 1)
        for n in (12, 24, 36)
    ]
    assert np.median(error[1]) < 0.2 * np.median(error[0])
    assert np.median(error[2]) < 2e-4
    assert error[2].max() < 2e-3


@pytest.mark.parametrize("name", ["two coats", "complex index", "dielectric"])
def test_walk_agrees(name: str) -> None:
    wi, wo = directions(120, 7), directions(120, 8)
    f = adding_doubling.solve(STACKS[name], wi, wo, nodes=32, modes=32)
    walked, se = simulate(STACKS[name], wi, wo, walks=8_000, seed=9)
    z = (walked - f) / np.hypot(se, 0.002 * f)
    assert np.all(np.mean(z**2, axis=0) < 1.4)
    np.testing.assert_allclose(np.median(walked / f, axis=0), 1, atol=5e-3)
