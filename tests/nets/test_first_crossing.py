"""The first crossing against the same light by other means."""

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.checks import CoatParameters
from urushi.core.namespace import NUMPY, Components, components, stacked_components
from urushi.nets import lobe as lobes
from urushi.nets.first_crossing import FLOOR, FirstCrossing, crossed_log, refracted

PAIRS = 48


@pytest.fixture(scope="module")
def basis():
    return untrained(functions=12).networks.basis


@pytest.fixture(scope="module")
def crossing(basis) -> FirstCrossing:
    return FirstCrossing.of(basis, PAIRS)


@pytest.fixture(scope="module")
def rest(basis) -> np.ndarray:
    return 0.3 * np.random.default_rng(0).standard_normal((6, basis.size)).astype(np.float32)


def coats(**given) -> CoatParameters:
    usual = {"alpha": 0.1, "eta": 1.5, "albedo": 0.0, "sigma_t": 0.0, "g": 0.0}
    return CoatParameters(*(np.full(6, x, np.float32) for x in (usual | given).values()))


def lobe_of(*numbers: float) -> np.ndarray:
    return np.tile(np.array(numbers, np.float32), (6, 1))


def test_nothing_changes_codes_under_no_coat(crossing, rest):
    codes = crossing.codes(rest, lobe_of(*lobes.NO_LOBE), coats(eta=1.0))
    np.testing.assert_allclose(codes, rest, atol=5e-3)  # functions of tables, at the same pairs


def test_directions_follow_snell(crossing):
    for eta in (0.7, 1.3, 2.5):
        inside = refracted(components(crossing.wi), eta, NUMPY)
        sines = np.hypot(crossing.wi[:, 0], crossing.wi[:, 1]), np.hypot(inside.x, inside.y)
        passes = sines[0] < 0.99 * eta
        np.testing.assert_allclose(sines[0][passes], eta * sines[1][passes], rtol=1e-5)
        size = inside.x**2 + inside.y**2 + inside.z**2
        np.testing.assert_allclose(size, 1, rtol=1e-5)


def test_functions_between_nodes_are_those_of_the_basis(crossing, basis, rest):
    """Interpolated linearly between 16 indices: to a few per cent of f."""
    eta = np.linspace(1.05, 2.9, 6).astype(np.float32)
    found = crossing.rest_logs(rest, eta)
    for row, index in enumerate(eta):
        below = (refracted(components(w), index, NUMPY) for w in (crossing.wi, crossing.wo))
        rows = basis.at(*(stacked_components(w, np) for w in below))
        error = found[row] - (rows[:, 0] + rows[:, 1:] @ rest[row])
        assert np.abs(error).mean() < 0.05


def test_slopes_are_those_of_differences(crossing, rest):
    eta, step = np.linspace(0.6, 2.8, 6), 1e-4
    found, z = crossing.slopes(rest, eta), rest.astype(np.float64)
    by_eta = (crossing.rest_logs(z, eta + step) - crossing.rest_logs(z, eta - step)) / (2 * step)
    np.testing.assert_allclose(found[:, -1], by_eta, atol=1e-3)
    change = np.random.default_rng(1).standard_normal(z.shape)
    by_code = crossing.rest_logs(z + change, eta) - crossing.rest_logs(z, eta)
    expected = (change[:, None] @ found[:, :-1])[:, 0]
    np.testing.assert_allclose(by_code, expected, atol=1e-4)


def test_a_deep_medium_that_scatters_once_hides_the_bottom():
    """albedo p / (c_i + c_o): of equal directions along the normal it is albedo p(back) / 2."""
    normal = Components(np.zeros(1), np.zeros(1), np.ones(1))
    for g in (0.0, 0.5):
        coat = [np.full(1, x) for x in (0.1, 1.5, 0.4, 50.0, g)]
        logs = crossed_log(np.zeros(1), lobes.NO_LOBE, coat, normal, normal, NUMPY)
        backwards = (1 - g * g) / (4 * np.pi * (1 + g) ** 3)
        np.testing.assert_allclose(np.exp(logs), 0.4 * backwards / 2 + FLOOR, rtol=1e-6)


def test_rough_interfaces_widen_the_lobe_of_the_bottom():
    """Its peak falls, and its tail rises."""
    wi = Components(np.zeros(2), np.zeros(2), np.ones(2))
    sine = np.array([0.0, 0.3])
    wo = Components(sine, np.zeros(2), np.sqrt(1 - sine**2))
    lobe = [0.05, 1.0, 1.0, 0.0, 1.5, 0.0]
    smooth, rough = (
        crossed_log(np.full(2, -25.0), lobe, [alpha, 1.5, 0, 0, 0], wi, wo, NUMPY)
        for alpha in (0.01, 0.5)
    )
    assert rough[0] < smooth[0] and rough[1] > smooth[1]
