"""Coats of index 1 are no interface: closed forms, another solver, equal stacks."""

import numpy as np
import pytest
from tests.oracles.adding_doubling import layers
from tests.oracles.adding_doubling.quadrature import CosineGrid, series

from urushi.checks import Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.walk import analytic, coat, conductor, dielectric, diffuse, simulate, slab

MEDIUM = {"albedo": (0.9, 0.5, 1.0), "g": 0.3}


@pytest.fixture(scope="module")
def pairs():
    return cosine_pairs(np.random.default_rng(8), 60)


@pytest.mark.parametrize("alpha", [0.01, 0.5, Widths(0.1, 0.8)])
def test_an_absorbing_medium_is_beers_law(pairs, alpha):
    depth, inverse = np.array([0.0, 0.3, 1.2]), 1 / pairs[0][:, 2] + 1 / pairs[1][:, 2]
    f, _ = simulate(coat(diffuse(0.5), alpha, 1, sigma_t=tuple(depth)), *pairs, walks=64)
    expected = 0.5 / np.pi * np.exp(-inverse[:, None] * depth)
    np.testing.assert_allclose(f, expected, rtol=1e-4)


@pytest.mark.parametrize(
    "bottom", [conductor(0.05, (0.9, 0.5, 0.2)), dielectric(0.2, 1.5), dielectric(0.2, 1)]
)
def test_no_interface_and_no_medium_is_the_bottom(pairs, bottom):
    for stack in (coat(bottom, 0.4, 1), coat(coat(bottom, 0.4, 1), 0.02, 1)):
        f, _ = simulate(stack, *pairs, walks=16)
        np.testing.assert_allclose(f, analytic.f(bottom, *pairs), rtol=1e-5)


@pytest.mark.parametrize("g", [0.0, 0.5])
def test_a_scattering_medium_is_the_solvers_slab(g):
    """Its reflection over black, and its transmission without a bottom. The solver has 0.01 %."""
    grid = CosineGrid.gauss(nodes=16, modes=48)
    first, second = (x.ravel() for x in np.indices((16, 16))[:, 4::4, 5::4])  # no straight light
    phi, sines = np.linspace(0, np.pi, len(first)), np.sqrt(1 - grid.mu**2)
    wi = np.stack([sines[first], 0 * phi, grid.mu[first]], axis=1)
    # The solver's azimuth is that between directions of propagation.
    wo = np.stack([-sines[second] * np.cos(phi), sines[second] * np.sin(phi), grid.mu[second]], 1)
    medium = (0.3, 1, 0.9, 2.0, g)
    stacks = coat(diffuse(0), *medium), slab(*medium)
    for modes, stack, side in zip(layers.slab(grid, *medium[2:]), stacks, (1, -1), strict=True):
        expected = series(modes[:, first, second], phi) / (grid.root[first] * grid.root[second])
        f, se = simulate(stack, wi, wo * [1, 1, side], walks=1 << 14, seed=3)
        error = np.abs(f[:, 0] - expected)
        np.testing.assert_array_less(error, 4.5 * se[:, 0] + 1e-3 * expected)


@pytest.mark.parametrize("outer", [1.5, 1.0])
def test_media_of_one_index_are_one_medium(pairs, outer):
    """At 1.5 the interface of index 1 is between the media, otherwise on top of all."""
    bottom, walks = conductor(0.3, 0.8), 1 << 13
    inner = coat(bottom, 0.4, 1, sigma_t=0.4, **MEDIUM)
    once, twice = (
        coat(below, 0.1, outer, sigma_t=depth, **MEDIUM)
        for below, depth in ((bottom, 1.0), (inner, 0.6))
    )
    (f, se), (expected, error) = (simulate(s, *pairs, walks=walks) for s in (twice, once))
    np.testing.assert_array_less(np.abs(f - expected), 5 * np.hypot(se, error) + 1e-6)
    assert f.mean() == pytest.approx(expected.mean(), rel=0.01)


def test_a_medium_above_a_surface(pairs):
    """A medium of index 1 that absorbs attenuates what is below it, a coat included."""
    glass = coat(diffuse(0.6), 0.2, 1.5, sigma_t=0.2)
    inverse = 1 / pairs[0][:, 2] + 1 / pairs[1][:, 2]
    f, se = simulate(coat(glass, 0.9, 1, sigma_t=0.3), *pairs, walks=1 << 12)
    bare, error = simulate(glass, *pairs, walks=1 << 12, seed=1)
    passed = np.exp(-0.3 * inverse)[:, None]
    np.testing.assert_array_less(np.abs(f - bare * passed), 5 * np.hypot(se, error * passed))


def test_smooth_coats_near_one_are_near_it(pairs):
    """Their refraction shortens steep paths by less than 0.4 %."""
    for eta in (0.999, 1.001):
        depth = {"sigma_t": 0.5}
        f, se = simulate(coat(diffuse(0.5), 0.01, eta, **depth), *pairs, walks=1 << 10)
        expected, _ = simulate(coat(diffuse(0.5), 0.01, 1, **depth), *pairs, walks=16)
        steep = (np.minimum(pairs[0][:, 2], pairs[1][:, 2]) > 0.5)[:, None]
        np.testing.assert_array_less(steep * np.abs(f - expected), 5 * se + 0.01 * expected)
