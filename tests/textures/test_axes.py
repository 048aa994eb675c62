"""Axes of parameters: coordinates, interpolation between nodes and points."""

import numpy as np
import pytest

from urushi.core.namespace import NUMPY
from urushi.textures import axes, point_codes
from urushi.textures.axes import Axis
from urushi.textures.interpolation import interpolant, points


@pytest.mark.parametrize(
    "scale", [axes.WIDTH, axes.DEPTH, axes.REFLECTANCE, axes.LINEAR, axes.ALBEDO, axes.INDEX]
)
def test_coordinates_are_inverse_to_values(scale):
    axis = Axis("x", scale, 0.02, 0.9)
    coordinates = np.linspace(0, 1, 33)
    found = axis.coordinate(axis.values(coordinates), NUMPY)
    np.testing.assert_allclose(found, coordinates, atol=1e-12)


def test_values_beyond_the_range_are_its_ends():
    axis = Axis("x", axes.WIDTH, 0.1, 0.5)
    np.testing.assert_array_equal(axis.coordinate(np.array([0.0, 2.0]), NUMPY), [0, 1])


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_simplices_interpolate_linear_functions_exactly(dimensions):
    """Weights are not negative and add up to one."""
    shape = (5, 4, 3, 6)[:dimensions]
    x = np.random.default_rng(0).random((100, dimensions))
    x[:2] = [[0] * dimensions, [1] * dimensions]
    sides = (np.linspace(0, 1, count) for count in shape)
    nodes = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, dimensions)
    corners = axes.simplex(shape, x.T, axes.whole_numbers, NUMPY)
    assert len(corners) == dimensions + 1
    weights = np.stack([weight for _, weight in corners])
    assert (weights >= 0).all()
    np.testing.assert_allclose(weights.sum(axis=0), 1)
    found = sum(weight[:, None] * nodes[node] for node, weight in corners)
    np.testing.assert_allclose(found, x, atol=1e-12)


@pytest.mark.parametrize("dimensions", [1, 3])
def test_interpolants_take_their_values(dimensions):
    """Of points that coincide but for rounding, their mean."""
    x = points([16] * dimensions, 40)
    values = np.sin(3 * x.sum(axis=1))[:, None]
    found = interpolant(x, values, np.eye(1))
    np.testing.assert_allclose(found(x), values, atol=1e-4)
    twice = interpolant(
        np.tile(x, (2, 1)), np.concatenate([values - 1e-6, values + 1e-6]), np.eye(1)
    )
    np.testing.assert_allclose(twice(x), values, atol=2e-5)


def test_interpolants_find_the_coordinates_that_matter():
    """Two of six: as accurate as if the others did not exist."""
    x, other = points([16] * 6, 200), np.random.default_rng(0).random((100, 6))

    def values(y):
        return np.exp(-4 * y[:, 1:2]) + y[:, 4:5] ** 2

    found = interpolant(x, values(x), np.eye(1))
    np.testing.assert_allclose(found(other), values(other), atol=2e-3)


def test_slopes_of_quadratics_are_exact():
    """Between and at the ends of three places."""
    places = np.sort(np.random.default_rng(0).random((30, 3)), axis=1)
    at = np.where(np.arange(30) % 2, places[:, 0], places.mean(axis=1))
    found = np.sum(point_codes.slope_weights(places, at) * (2 * places**2 - 3 * places + 1), axis=1)
    np.testing.assert_allclose(found, 4 * at - 3, atol=1e-8)
