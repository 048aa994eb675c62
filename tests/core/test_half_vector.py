"""Half and difference angles against the vectors that define them (Rusinkiewicz 1998)."""

import numpy as np
import pytest

from urushi.core.directions import (
    above_horizon,
    directions_at,
    directions_at_tangent,
    half_difference_angles,
)

COUNT = 2000
ANGLES = np.random.default_rng(0).random((3, COUNT)) * [[0.5 * np.pi], [0.5 * np.pi], [np.pi]]


@pytest.fixture(scope="module")
def pairs():
    return directions_at(*ANGLES)


def test_half_vector_and_difference_angle_are_the_given_ones(pairs):
    wi, wo = pairs
    theta_h, theta_d, _ = ANGLES
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    expected = np.stack([np.sin(theta_h), np.zeros(COUNT), np.cos(theta_h)], axis=1)
    # Near theta_d = 90 degrees the sum of the directions loses digits.
    np.testing.assert_allclose(half, expected, atol=1e-11)
    for w in pairs:
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, rtol=1e-12)
        np.testing.assert_allclose((w * expected).sum(1), np.cos(theta_d), atol=1e-12)


def test_azimuth_counts_from_the_plane_of_the_half_vector_and_the_normal():
    wi, wo = directions_at(np.array([0.3]), np.array([0.2]), np.array([0.0]))
    np.testing.assert_allclose(wi, [[np.sin(0.5), 0, np.cos(0.5)]], atol=1e-12)
    np.testing.assert_allclose(wo, [[np.sin(0.1), 0, np.cos(0.1)]], atol=1e-12)


def test_angles_of_directions_are_the_given_ones(pairs):
    above = above_horizon(*ANGLES)
    assert 0.2 < above.mean() < 0.9
    np.testing.assert_array_equal(above, (pairs[0][:, 2] > 0) & (pairs[1][:, 2] > 0))
    found = half_difference_angles(pairs[0][above], pairs[1][above])
    np.testing.assert_allclose(found, ANGLES[:, above], atol=1e-7)


def test_exchange_keeps_the_angles_bit_for_bit(pairs):
    for a, b in zip(
        half_difference_angles(*pairs), half_difference_angles(*pairs[::-1]), strict=True
    ):
        np.testing.assert_array_equal(a, b)


def test_tangent_gives_the_same_directions(pairs):
    found = directions_at_tangent(np.tan(ANGLES[0]), *ANGLES[1:])
    np.testing.assert_allclose(found, pairs, atol=1e-12)
