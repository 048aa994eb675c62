"""Axes of parameters: coordinates, interpolation between nodes, splines."""

import numpy as np
import pytest

from urushi.core.namespace import NUMPY
from urushi.textures import axes, baking
from urushi.textures.axes import Axis
from urushi.textures.spline import points, spline


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
def test_splines_take_their_values_and_are_exact_for_linear_functions(dimensions):
    x = points(dimensions, 40)
    slope = np.arange(1, dimensions + 1)
    linear = (x @ slope)[:, None]
    other = np.random.default_rng(0).random((100, dimensions))
    np.testing.assert_allclose(spline(x, linear)(other)[:, 0], other @ slope, atol=1e-8)
    values = np.sin(3 * linear)
    np.testing.assert_allclose(spline(x, values)(x), values, atol=1e-8)


def test_slopes_of_quadratics_are_exact():
    """Between and at the ends of three places."""
    places = np.sort(np.random.default_rng(0).random((30, 3)), axis=1)
    at = np.where(np.arange(30) % 2, places[:, 0], places.mean(axis=1))
    found = np.sum(baking.slope_weights(places, at) * (2 * places**2 - 3 * places + 1), axis=1)
    np.testing.assert_allclose(found, 4 * at - 3, atol=1e-8)
