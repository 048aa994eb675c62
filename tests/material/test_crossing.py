"""Light across a rough interface: densities, weights and reciprocity."""

import numpy as np
import pytest

from urushi.checks import Widths
from urushi.core import fresnel
from urushi.core.namespace import NUMPY, Components
from urushi.core.probe_pairs import even_points
from urushi.material.crossing import cross, crossing_at, in_plane, inner_albedo

COSINES = np.float32([[1.0], [0.8], [0.4], [0.1]])
POINTS = even_points(64, 2).astype(np.float32)


@pytest.mark.parametrize("eta", [1.5, 0.7])
@pytest.mark.parametrize("alpha", [0.05, 0.5, Widths(0.1, 0.4)])
@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_drawn_and_given_directions_agree(alpha, eta, turn):
    """Seen along x or between the axes."""
    sine, _, cosine = in_plane(COSINES)
    seen = Components(sine * np.float32(np.cos(turn)), sine * np.float32(np.sin(turn)), cosine)
    drawn = cross(seen, alpha, eta, POINTS)
    given = crossing_at(seen, drawn.inside, alpha, eta)
    present = drawn.weight > 0
    assert present.mean() > 0.4
    np.testing.assert_allclose(given.weight[present], drawn.weight[present], rtol=1e-3)
    np.testing.assert_allclose(given.density[present], drawn.density[present], rtol=2e-3)
    np.testing.assert_allclose(sum(x * x for x in drawn.inside), 1, rtol=1e-5)


def test_equal_widths_are_one():
    one, two = (cross(in_plane(COSINES), w, 1.5, POINTS) for w in (0.2, Widths(0.2, 0.2)))
    for a, b in zip((*one.inside, *one[1:]), (*two.inside, *two[1:]), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("eta", [1.5, 0.7])
def test_the_density_integrates_to_what_crosses(eta):
    """Over the hemisphere inside, density and weight give the mean weight of drawn directions."""
    alpha, cosine = 0.4, np.float32([[0.7]])
    points = even_points(4096, 2).astype(np.float32)
    mean = cross(in_plane(cosine), alpha, eta, points).weight.mean()
    u = even_points(1 << 18, 2)
    sine, phi = np.sqrt(1 - u[:, 0] ** 2), 2 * np.pi * u[:, 1]
    inside = Components(*(np.float32(x) for x in (sine * np.cos(phi), sine * np.sin(phi), u[:, 0])))
    found = crossing_at(in_plane(cosine), inside, alpha, eta)
    assert 2 * np.pi * (found.density * found.weight).mean() == pytest.approx(mean, rel=0.01)


def test_smooth_interfaces_are_those_of_fresnel():
    eta = 1.5
    found = cross(in_plane(COSINES), 0.01, eta, POINTS).weight.mean(axis=1)
    cosines = COSINES[:, 0].astype(float)
    one, zero = np.full(len(cosines), eta), np.zeros(len(cosines))
    np.testing.assert_allclose(found, 1 - fresnel.exact(cosines, one, zero, NUMPY), rtol=0.02)
    inner = inner_albedo(in_plane(np.array([[1.0], [0.9], [0.5]], np.float32)), 0.01, eta)
    expected = fresnel.exact(np.array([1.0, 0.9]), 1 / one[:2], zero[:2], NUMPY)
    np.testing.assert_allclose(inner[:2], expected, rtol=0.02)
    assert inner[2] == pytest.approx(1, abs=0.01)  # total reflection
