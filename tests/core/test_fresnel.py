"""Fresnel terms at the limits of their indices; `tests.walk.test_closed_forms` has the others."""

import numpy as np
import pytest

from urushi.core import fresnel
from urushi.core.namespace import NUMPY

COSINES = np.linspace(0.01, 1, 500, dtype=np.float32)


@pytest.mark.parametrize("eta", [0.5, 0.67, 0.99, 1.0, 1.01, 1.5, 3.0])
def test_a_conductor_that_absorbs_nothing_is_a_dielectric(jit, eta: float) -> None:
    """With total reflection below an index of one."""
    cos = jit.Float64(COSINES)
    expected, cos_t = (x.numpy() for x in fresnel.dielectric(cos, jit.Float64(eta)))
    for k in (jit.Float64(0), None):
        metal = fresnel.exact(cos, jit.Float64(eta), k).numpy()
        np.testing.assert_allclose(metal, expected, atol=1e-10)
    total = eta**2 < 1 - COSINES.astype(np.float64) ** 2
    assert np.array_equal(expected == 1, total) and np.array_equal(cos_t == 0, total)


@pytest.mark.parametrize("eta", (1 - 1e-6, 1, 1 + 1e-6, 1.001))
@pytest.mark.parametrize("k", (0, 1e-4))
def test_indices_near_one_reflect_no_negative_light(eta, k) -> None:
    """And in single precision what they reflect in double, to its rounding."""
    cosines = np.random.default_rng(4).random(2000)
    single = fresnel.exact(*map(np.float32, (cosines, eta, k)), NUMPY)
    assert (single >= 0).all()
    double = fresnel.exact(*(np.float64(np.float32(x)) for x in (cosines, eta, k)), NUMPY)
    np.testing.assert_allclose(single, double, atol=2e-6)
