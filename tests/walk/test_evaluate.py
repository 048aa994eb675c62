"""Surfaces without coats: closed forms, energy and reciprocity."""

import numpy as np
import pytest

from urushi.walk import conductor, dielectric, diffuse
from urushi.walk.analytic import f

DESCRIPTIONS = {
    "schlick": conductor((0.1, 0.3, 1.0), 0.5),
    "complex": conductor(0.3, eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9)),
    "dielectric": dielectric(0.2, (1.1, 1.5, 3.0)),
    "diffuse": diffuse((0.1, 0.5, 1.0)),
}


def hemisphere(count: int, seed: int) -> np.ndarray:
    """Unit vectors (count, 3) above the horizon."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def ggx(wi: np.ndarray, wo: np.ndarray, alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """D G / (4 cos cos) and wi.m in float64, from the slopes of facets (Heitz 2014)."""
    m = wi + wo
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    tan2 = 1 / m[:, 2] ** 2 - 1
    d = np.exp(-2 * np.log1p(tan2 / alpha**2)) / (np.pi * alpha**2 * m[:, 2] ** 4)

    def masking(w: np.ndarray) -> np.ndarray:
        tan = np.tan(np.arccos(w[:, 2]))
        return 1 / (1 + (np.sqrt(1 + (alpha * tan) ** 2) - 1) / 2)

    g = masking(wi) * masking(wo)
    return d * g / (4 * wi[:, 2] * wo[:, 2]), np.sum(wi * m, axis=1)


def test_conductors_follow_the_closed_form() -> None:
    wi, wo = hemisphere(500, 0), hemisphere(500, 1)
    for alpha in (0.05, 0.5, 1.0):
        lobe, cos = ggx(wi, wo, alpha)
        schlick = lobe * (0.3 + 0.7 * (1 - cos) ** 5)
        np.testing.assert_allclose(f(conductor(alpha, 0.3), wi, wo)[:, 0], schlick, rtol=2e-4)
        # Fresnel's equations with a complex index, amplitudes first
        index = 0.9 - 2.4j
        cos_t = np.sqrt(1 - (1 - cos**2) / index**2 + 0j)
        s = (cos - index * cos_t) / (cos + index * cos_t)
        p = (index * cos - cos_t) / (index * cos + cos_t)
        exact = lobe * (np.abs(s) ** 2 + np.abs(p) ** 2) / 2
        found = f(conductor(alpha, eta=0.9, k=2.4), wi, wo)[:, 0]
        np.testing.assert_allclose(found, exact, rtol=3e-4)


def test_diffuse_is_constant() -> None:
    value = f(diffuse((0.1, 0.5, 1.0)), hemisphere(10, 4), hemisphere(10, 5))
    np.testing.assert_allclose(value, np.broadcast_to([0.1, 0.5, 1.0], (10, 3)) / np.pi, rtol=1e-6)


@pytest.mark.parametrize("description", DESCRIPTIONS.values(), ids=DESCRIPTIONS.keys())
def test_surfaces_are_reciprocal_and_dark_below_the_horizon(description) -> None:
    wi, wo = hemisphere(500, 6), hemisphere(500, 7)
    there, back = f(description, wi, wo), f(description, wo, wi)
    assert there.dtype == np.float32
    assert there.shape == (500, 3)
    assert np.all(there >= 0)
    np.testing.assert_allclose(there, back, rtol=1e-5)
    down = wo * [1, 1, -1]
    assert not f(description, wi, down).any()
    assert not f(description, down, wi).any()
    assert not f(description, down, down).any()


def test_no_directions_give_no_values() -> None:
    nothing = np.zeros((0, 3))
    for description in DESCRIPTIONS.values():
        assert f(description, nothing, nothing).shape == (0, 3)
