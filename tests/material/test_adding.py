"""Adding and doubling inside a coat: another solver, closed forms, and what lies between nodes."""

import numpy as np
import pytest
from tests.oracles.adding_doubling import layers
from tests.oracles.adding_doubling.quadrature import CosineGrid, interpolation

from urushi.material import adding
from urushi.nets import lobe as lobes

#: Thin to thick media, of albedos down to a half, that scatter backwards, evenly and forwards.
MEDIA = [
    (1.0, 0.05, 0.9),
    (0.5, 0.5, 0.5),
    (0.9, 0.5, -0.9),
    (0.9, 2.0, -0.5),
    (0.9, 2.0, 0.9),
    (1.0, 10.0, -0.9),
    (0.99, 20.0, 0.0),
    (0.99, 20.0, 0.9),
]


@pytest.mark.parametrize(("albedo", "sigma_t", "g"), MEDIA)
def test_media_are_those_of_the_solver_on_another_grid(albedo, sigma_t, g):
    assert_as_by_the_solver(albedo, sigma_t, g)


def test_what_the_grids_differ_by_vanishes_on_a_finer_grid(monkeypatch):
    fine = adding.Grid(2 * adding.ELEVATIONS, 2 * adding.AZIMUTHS)
    monkeypatch.setattr(adding, "grid", lambda edges=(): fine)
    monkeypatch.setattr(adding, "medium", adding.medium.__wrapped__)  # without its cache
    monkeypatch.setattr(adding, "FIRST_DEPTH", adding.FIRST_DEPTH / 100)
    assert_as_by_the_solver(0.9, 2.0, 0.9)


def assert_as_by_the_solver(albedo, sigma_t, g):
    """Compare reflection and transmission with those of the validating solver.

    It shares no code: nodes are those of Gauss in the cosine, the phase function is a Legendre
    series, and doubling begins at 2e-8. The tolerance has two parts, both of `adding`'s grid. Its
    first layer scatters once only. That leaves out a share of the light like the layer's depth, and
    changes the attenuation of a thick medium by as much for each unit of its depth. And the grid
    integrates a phase function up to the degree that is its number of azimuths; Legendre's moments
    above are powers of g from there on, a few of which add up.
    """
    own = adding.grid()
    tolerance = adding.FIRST_DEPTH * (2 + sigma_t / 2) + 4 * abs(g) ** (2 * own.azimuths.size - 2)
    ends = np.r_[0.5, np.ones(len(own.azimuths) - 2), 0.5]  # of the trapezium rule
    share = np.multiply.outer(np.outer(own.weights, own.weights), ends)
    both = zip(adding.medium(albedo, sigma_t, g), solved(albedo, sigma_t, g), strict=True)
    for modes, expected in both:
        found = own.values_of_modes(modes)
        assert (np.abs(found - expected) * share).sum() < tolerance * (expected * share).sum()
        # The light that leaves the medium, for each direction from which it comes.
        light, expected_light = (m[0] @ own.weights for m in (modes, own.modes(expected)))
        np.testing.assert_allclose(light, expected_light, rtol=0, atol=tolerance)


def solved(albedo, sigma_t, g, nodes=64, modes=64):
    """Reflection and transmission of scattered light by the solver, values (N, N, H) [1/sr]."""
    own, grid = adding.grid(), CosineGrid.gauss(nodes, modes)
    reflected, passed = layers.slab(grid, albedo, sigma_t, g)
    passed = passed - np.diag(layers.direct(grid, sigma_t))
    basis = interpolation(grid, own.cosines) / grid.root  # weights of both sides are taken out
    m = np.arange(len(reflected))
    series = np.where(m == 0, 1, 2)[:, None] * np.cos(m[:, None] * own.azimuths)
    # Directions of propagation there; here both point away from what reflects.
    for operator, signs in ((reflected, (-1.0) ** m), (passed, np.ones(len(m)))):
        values = basis @ operator @ basis.T
        yield np.einsum("mij,mh->ijh", values, signs[:, None] * series)


def test_a_lambertian_bottom_below_a_smooth_interface():
    """Diffuse light is reflected back to the bottom by the interface's mean albedo (Saunderson)."""
    own, rho, eta = adding.grid(), 0.7, 1.5
    bottom = adding.bottom_modes(lambda wi, wo: np.full((len(wi), 1), rho / np.pi))[0]
    interface = adding.interface_modes(0.01, eta)
    more, depth = adding.seen_inside(bottom, interface, [(0.0, 0.0, 0.0)])
    inner = 2 * (interface[0] @ own.weights) @ own.weights
    expected = rho / np.pi / (1 - rho * inner) - rho / np.pi
    np.testing.assert_allclose(more, expected, rtol=1e-4)
    assert depth == 0 and inner == pytest.approx(0.596, abs=0.01)  # Duntley 1942


def test_narrow_lobes_keep_their_albedo():
    metal = np.array([0.03, 1.0, 1.0, 0.0, 1.5, 0.0])
    f = lambda wi, wo: lobes.f(metal, wi.astype(float), wo.astype(float))[:, None]  # noqa: E731
    own = adding.grid()
    modes = adding.bottom_modes(f)[0]
    expected = np.minimum(adding.albedos(f, own.cosines)[:, 0], 1)
    found, steep = modes[0] @ own.weights, own.cosines > 0.2
    np.testing.assert_allclose(found[steep], expected[steep], rtol=1e-6)
    np.testing.assert_allclose(found, expected, rtol=0.05)  # neighbours meet the lobe too
    np.testing.assert_allclose(modes, np.swapaxes(modes, 1, 2), atol=1e-8)


def test_values_between_the_nodes():
    own = adding.grid()
    wi, wo = own.pairs()
    f = 1 + wi[:, 2] * wo[:, 2] + 0.5 * (wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])
    values = own.values(f.astype(float))
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(2, 200, 3))
    pairs[..., 2] = np.abs(pairs[..., 2])
    a, b = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    expected = 1 + a[:, 2] * b[:, 2] + 0.5 * (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])
    found = own.interpolated(values[..., None], a, b)[:, 0]
    np.testing.assert_allclose(found, expected, atol=0.01)
    np.testing.assert_allclose(own.values_of_modes(own.modes(values)), values, atol=1e-12)
