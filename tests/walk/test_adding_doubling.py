"""The adding-doubling solver: an exact limit, convergence, and the random walk."""

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.oracles import adding_doubling
from tests.oracles.adding_doubling import layers
from tests.oracles.adding_doubling.quadrature import CosineGrid

from urushi.walk import coat, conductor, dielectric, diffuse, simulate

pytestmark = pytest.mark.slow  # of an oracle of the tests alone


STACKS = {
    "two coats": coat(
        coat(conductor(0.3, 0.8), 0.4, 1.3, 0.9, (2.0, 0.5, 0.0), g=0.5),
        *(0.25, 1.4, (0.95, 0.8, 1.0), (0.5, 3.0, 1.0)),
        g=-0.5,
    ),
    # A medium of a lower index than the coat above it.
    "thinner medium": coat(
        coat(diffuse(0.8), 0.3, 0.8, 0.95, (1.0, 0.3, 8.0), g=(0.9, -0.8, 0.0)), 0.25, 1.5, 0.9, 0.5
    ),
    "complex index": coat(conductor(0.4, eta=0.2, k=3.0), 0.3, 1.4, 0.5, 0.5),
    "dielectric": coat(dielectric(0.4, 1.7), 0.3, 1.4, 0.5, 0.5),
}


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


def test_converges_with_nodes_and_modes() -> None:
    wi, wo = pairs_above(60, 3, 0.05)
    stack = coat(conductor(0.15, 0.9), 0.15, 1.5, 0.95, 1.0, g=0.5)
    best = adding_doubling.solve(stack, wi, wo, nodes=64, modes=64)[:, 0]
    error = [
        np.abs(adding_doubling.solve(stack, wi, wo, nodes=n, modes=n)[:, 0] / best - 1)
        for n in (12, 24, 36)
    ]
    assert np.median(error[1]) < 0.2 * np.median(error[0])
    assert np.median(error[2]) < 2e-4
    assert error[2].max() < 2e-3


@pytest.mark.parametrize("name", STACKS)
def test_walk_agrees(name: str) -> None:
    wi, wo = pairs_above(120, 7, 0.05)
    f = adding_doubling.solve(STACKS[name], wi, wo, nodes=32, modes=32)
    walked, se = simulate(STACKS[name], wi, wo, walks=8_000, seed=9)
    z = (walked - f) / np.hypot(se, 0.002 * f)
    assert np.all(np.mean(z**2, axis=0) < 1.4)
    np.testing.assert_allclose(np.median(walked / f, axis=0), 1, atol=5e-3)
