"""Directions: bases, turns about the normal, half and difference angles."""

import numpy as np

from urushi.core import directions
from urushi.core.directions import (
    above_horizon,
    directions_at,
    directions_at_tangent,
    half_difference,
    rotated,
)
from urushi.core.namespace import NUMPY, components

COUNT = 2000
#: Half and difference angles and azimuths (Rusinkiewicz 1998).
ANGLES = np.random.default_rng(0).random((3, COUNT)) * [[0.5 * np.pi], [0.5 * np.pi], [np.pi]]
VECTORS = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)


PAIRS = directions_at(*ANGLES)


def test_from_versine_keeps_the_angle_to_the_axis(jit) -> None:
    """Of any axis, also along the normal. Interfaces test reflection and refraction."""
    v = np.random.default_rng(7).normal(size=(3, 1000)).astype(np.float32)
    v[:, 500:502] = [[0, 0], [0, 0], [1, -1]]
    axis, cos = v / np.linalg.norm(v, axis=0), np.linspace(-1, 1, 1000, dtype=np.float32)
    phi = jit.Float(np.linspace(0, 40, 1000, dtype=np.float32))
    w = directions.from_versine(jit.Array3f(axis), jit.Float(1 - cos), phi).numpy()
    np.testing.assert_allclose(np.sum(w * axis, axis=0), cos, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=1e-6)


def test_rotations_turn_x_to_y_add_up_and_may_mirror() -> None:
    quarter = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(rotated(np.eye(3), 0.25), quarter, 0, 1e-7)
    turned = rotated(VECTORS, 0.2)
    np.testing.assert_allclose(rotated(turned, 0.3), rotated(VECTORS, 0.5), atol=1e-6)
    np.testing.assert_array_equal(rotated(VECTORS, 0.2, True), turned * np.float32([1, -1, 1]))


def test_half_vector_and_difference_angle_are_the_given_ones():
    wi, wo = PAIRS
    again = directions_at_tangent(np.tan(ANGLES[0]), *ANGLES[1:])
    np.testing.assert_allclose(again, PAIRS, 0, 1e-12)
    theta_h, theta_d, _ = ANGLES
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    expected = np.stack([np.sin(theta_h), np.zeros(COUNT), np.cos(theta_h)], axis=1)
    # Near theta_d = 90 degrees the sum of the directions loses digits.
    np.testing.assert_allclose(half, expected, atol=1e-11)
    for w in PAIRS:
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, rtol=1e-12)
        np.testing.assert_allclose((w * expected).sum(1), np.cos(theta_d), atol=1e-12)


def test_azimuth_counts_from_the_plane_of_the_half_vector_and_the_normal():
    wi, wo = directions_at(np.array([0.3]), np.array([0.2]), np.array([0.0]))
    np.testing.assert_allclose(wi, [[np.sin(0.5), 0, np.cos(0.5)]], atol=1e-12)
    np.testing.assert_allclose(wo, [[np.sin(0.1), 0, np.cos(0.1)]], atol=1e-12)


def test_angles_of_directions_are_the_given_ones():
    above = above_horizon(*ANGLES)
    assert 0.2 < above.mean() < 0.9
    np.testing.assert_array_equal(above, (PAIRS[0][:, 2] > 0) & (PAIRS[1][:, 2] > 0))
    sides = [components(w[above]) for w in PAIRS]
    found = half_difference(*sides, NUMPY)
    np.testing.assert_allclose(found, ANGLES[:, above], atol=1e-7)
    np.testing.assert_array_equal(half_difference(*sides[::-1], NUMPY), found)
