"""Directions: reflection, refraction, bases, turns about the normal, half and difference angles."""

import numpy as np
import pytest

from urushi.core import directions, fresnel
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


@pytest.fixture(scope="module")
def pairs():
    return directions_at(*ANGLES)


def sphere(count: int, seed: int) -> np.ndarray:
    """Uniform unit vectors, (3, count)."""
    v = np.random.default_rng(seed).normal(size=(3, count)).astype(np.float32)
    return v / np.linalg.norm(v, axis=0)


def test_reflection_is_an_involution_about_the_normal(jit) -> None:
    w, m = sphere(1000, 0), sphere(1000, 1)
    mirrored = directions.reflect(jit.Array3f(w), jit.Array3f(m))
    both = mirrored.numpy() + w
    np.testing.assert_allclose(np.cross(both.T, m.T), 0, atol=1e-6)
    again = directions.reflect(mirrored, jit.Array3f(m))
    np.testing.assert_allclose(again.numpy(), w, atol=1e-6)


def test_refraction_obeys_snell(jit) -> None:
    w, m = sphere(1000, 2), sphere(1000, 3)
    m *= np.sign(np.sum(w * m, axis=0))  # to the side of w
    for eta in (1.5, 1 / 1.5, 3.0, 1.001):
        cos_i = np.sum(w * m, axis=0)
        _, cos_t = fresnel.dielectric(jit.Float(cos_i), eta)
        t = directions.refract(jit.Array3f(w), jit.Array3f(m), cos_t, eta).numpy()
        passes = cos_t.numpy() > 0
        assert passes.any()
        # The tangential part keeps its size times the index, and changes sides (w points away).
        tangential = np.cross(m.T, w.T) + eta * np.cross(m.T, t.T)
        np.testing.assert_allclose(tangential[passes], 0, atol=2e-6)
        assert np.all(np.sum(t * m, axis=0)[passes] < 0)
        np.testing.assert_allclose(np.linalg.norm(t, axis=0)[passes], 1, atol=2e-6)


def test_coordinate_systems_are_right_handed_and_orthonormal(jit) -> None:
    n = np.concatenate([sphere(1000, 6), [[0, 0], [0, 0], [1, -1]]], axis=1).astype(np.float32)
    s, t = (v.numpy().T for v in directions.coordinate_system(jit.Array3f(n)))
    basis = np.stack([s, t, n.T], axis=1)
    np.testing.assert_allclose(basis @ basis.transpose(0, 2, 1) - np.eye(3), 0, atol=2e-6)
    np.testing.assert_allclose(np.linalg.det(basis), 1, atol=2e-6)


def test_from_cosine_keeps_the_angle_to_the_axis(jit) -> None:
    axis, cos = sphere(1000, 7), np.linspace(-1, 1, 1000, dtype=np.float32)
    phi = jit.Float(np.linspace(0, 40, 1000, dtype=np.float32))
    w = directions.from_cosine(jit.Array3f(axis), jit.Float(cos), phi).numpy()
    np.testing.assert_allclose(np.sum(w * axis, axis=0), cos, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=1e-6)


def test_rotations_turn_x_to_y_add_up_and_may_mirror() -> None:
    quarter = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(rotated(np.eye(3), 0.25), quarter, 0, 1e-7)
    turned = rotated(VECTORS, 0.2)
    np.testing.assert_allclose(rotated(turned, 0.3), rotated(VECTORS, 0.5), atol=1e-6)
    np.testing.assert_array_equal(rotated(VECTORS, 0.2, True), turned * np.float32([1, -1, 1]))


def test_half_vector_and_difference_angle_are_the_given_ones(pairs):
    wi, wo = pairs
    again = directions_at_tangent(np.tan(ANGLES[0]), *ANGLES[1:])
    np.testing.assert_allclose(again, pairs, 0, 1e-12)
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
    sides = [components(w[above]) for w in pairs]
    found = half_difference(*sides, NUMPY)
    np.testing.assert_allclose(found, ANGLES[:, above], atol=1e-7)
    np.testing.assert_array_equal(half_difference(*sides[::-1], NUMPY), found)
