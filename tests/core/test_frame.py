"""Directions: reflection, refraction and bases."""

from types import ModuleType

import numpy as np

from urushi.core import directions, fresnel


def sphere(count: int, seed: int) -> np.ndarray:
    """Uniform unit vectors, (3, count)."""
    v = np.random.default_rng(seed).normal(size=(3, count)).astype(np.float32)
    return v / np.linalg.norm(v, axis=0)


def facing(w: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Normals m turned to the side of w."""
    return m * np.sign(np.sum(w * m, axis=0))


def test_reflection_is_an_involution_about_the_normal(jit: ModuleType) -> None:
    w, m = sphere(1000, 0), sphere(1000, 1)
    mirrored = directions.reflect(jit.Array3f(w), jit.Array3f(m))
    both = mirrored.numpy() + w
    np.testing.assert_allclose(np.cross(both.T, m.T), 0, atol=1e-6)
    again = directions.reflect(mirrored, jit.Array3f(m))
    np.testing.assert_allclose(again.numpy(), w, atol=1e-6)


def test_refraction_obeys_snell(jit: ModuleType) -> None:
    w, m = sphere(1000, 2), sphere(1000, 3)
    m = facing(w, m)
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


def test_refraction_is_reversible(jit: ModuleType) -> None:
    w, m = sphere(1000, 4), sphere(1000, 5)
    m = facing(w, m)
    _, cos_t = fresnel.dielectric(jit.Float(np.sum(w * m, axis=0)), 1.7)
    t = directions.refract(jit.Array3f(w), jit.Array3f(m), cos_t, 1.7)
    _, cos_back = fresnel.dielectric(cos_t, 1 / 1.7)
    back = directions.refract(t, jit.Array3f(-m), cos_back, 1 / 1.7)
    # At grazing angles the cosine is the root of a difference: half the digits remain.
    np.testing.assert_allclose(back.numpy(), w, atol=1e-3)


def test_coordinate_systems_are_right_handed_and_orthonormal(jit: ModuleType) -> None:
    n = np.concatenate([sphere(1000, 6), [[0, 0], [0, 0], [1, -1]]], axis=1).astype(np.float32)
    s, t = (v.numpy().T for v in directions.coordinate_system(jit.Array3f(n)))
    basis = np.stack([s, t, n.T], axis=1)
    np.testing.assert_allclose(basis @ basis.transpose(0, 2, 1) - np.eye(3), 0, atol=2e-6)
    np.testing.assert_allclose(np.linalg.det(basis), 1, atol=2e-6)


def test_from_cosine_keeps_the_angle_to_the_axis(jit: ModuleType) -> None:
    axis, cos = sphere(1000, 7), np.linspace(-1, 1, 1000, dtype=np.float32)
    phi = jit.Float(np.linspace(0, 40, 1000, dtype=np.float32))
    w = directions.from_cosine(jit.Array3f(axis), jit.Float(cos), phi).numpy()
    np.testing.assert_allclose(np.sum(w * axis, axis=0), cos, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(w, axis=0), 1, atol=1e-6)


def test_cosine_hemisphere_is_cosine_distributed(jit: ModuleType, sphere_test) -> None:
    u1, u2 = np.random.default_rng(8).random((2, 200_000), dtype=np.float32)
    w = directions.square_to_cosine_hemisphere(jit.Array3f, jit.Float(u1), jit.Float(u2)).numpy().T
    # One test with a fixed seed; a true density fails one in a thousand seeds.
    assert sphere_test(w, lambda v: np.maximum(v[:, 2], 0) / np.pi) > 1e-3
