"""Fresnel terms: limits, symmetry and agreement of the formulae."""

from types import ModuleType

import numpy as np
import pytest

from urushi.core import fresnel
from urushi.core.namespace import NUMPY

COSINES = np.linspace(0.01, 1, 500, dtype=np.float32)


def test_total_internal_reflection_starts_at_the_critical_angle(jit: ModuleType) -> None:
    critical = np.sqrt(1 - 1 / 1.5**2)
    reflectance, cos_t = (x.numpy() for x in fresnel.dielectric(jit.Float(COSINES), 1 / 1.5))
    total = critical - 1e-5 > COSINES
    assert np.all(reflectance[total] == 1)
    assert np.all(cos_t[total] == 0)
    assert np.all(reflectance[critical + 1e-5 < COSINES] < 1)


@pytest.mark.parametrize("eta", [1.2, 1.5, 3.0, 1 / 1.5])
def test_reflectance_is_a_fraction_and_one_at_grazing(jit: ModuleType, eta: float) -> None:
    reflectance = fresnel.dielectric(jit.Float(COSINES), eta)[0].numpy()
    assert np.all((reflectance >= 0) & (reflectance <= 1))
    assert fresnel.dielectric(jit.Float(0), eta)[0][0] == 1


@pytest.mark.parametrize("eta", [0.5, 0.67, 0.99, 1.0, 1.01, 1.5, 3.0])
def test_a_conductor_that_absorbs_nothing_is_a_dielectric(jit: ModuleType, eta: float) -> None:
    """With total reflection below an index of one."""
    cos = jit.Float64(COSINES)
    metal = fresnel.exact(cos, jit.Float64(eta), jit.Float64(0)).numpy()
    expected = fresnel.dielectric(cos, jit.Float64(eta))[0].numpy()
    np.testing.assert_allclose(metal, expected, atol=1e-10)
    assert (expected == 1).any() == (eta < 1)


def test_conductors_reflect_by_fresnels_amplitudes() -> None:
    """The squared complex amplitudes of both polarisations."""
    for eta, k in np.random.default_rng(3).uniform([0.1, 0], [4, 9], (50, 2)):
        index = eta - 1j * k
        inside = np.sqrt(index**2 - 1 + COSINES.astype(np.float64) ** 2)
        across = (COSINES - inside) / (COSINES + inside)
        along = (index**2 * COSINES - inside) / (index**2 * COSINES + inside)
        expected = 0.5 * (np.abs(across) ** 2 + np.abs(along) ** 2)
        found = fresnel.exact(COSINES.astype(np.float64), eta, k, NUMPY)
        np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.parametrize("eta", (1 - 1e-6, 1, 1 + 1e-6, 1.001))
@pytest.mark.parametrize("k", (0, 1e-4))
def test_indices_near_one_reflect_no_negative_light(eta, k) -> None:
    """And in single precision what they reflect in double, to its rounding."""
    cosines = np.random.default_rng(4).random(2000)
    single = fresnel.exact(*map(np.float32, (cosines, eta, k)), NUMPY)
    assert (single >= 0).all()
    double = fresnel.exact(*(np.float64(np.float32(x)) for x in (cosines, eta, k)), NUMPY)
    np.testing.assert_allclose(single, double, atol=2e-6)


def test_schlick_spans_r0_to_one_for_colours(jit: ModuleType) -> None:
    r0 = jit.Array3f(0.04, 0.5, 1.0)
    np.testing.assert_allclose(fresnel.schlick(jit.Float(1), r0).numpy()[:, 0], [0.04, 0.5, 1.0])
    np.testing.assert_allclose(fresnel.schlick(jit.Float(0), r0).numpy()[:, 0], 1)
    values = fresnel.schlick(jit.Float(COSINES), jit.Float(0.04)).numpy()
    assert np.all(np.diff(values) <= 0)
