"""Fitted lobes: exact recovery, and agreement with the oracle of surfaces."""

import numpy as np
import pytest
from benchmarks.rivals.ggx_fit import GgxFit, Lobe, fit
from tests.oracles import surfaces

ONE = GgxFit(np.array([0.3, 0.2, 0.1]), (Lobe(0.08, 0.04, np.array([1.0, 0.9, 0.8])),))
TWO = GgxFit(ONE.diffuse, (*ONE.lobes, Lobe(0.3, 0.3, np.array([0.2, 0.3, 0.5]))))


def test_two_lobes_are_found_again(random_directions):
    found = fit(TWO.f, 2, "root")
    assert sorted(lobe.alpha for lobe in found.lobes) == pytest.approx([0.08, 0.3], rel=0.01)
    wi, wo = (random_directions(500, seed, least_cosine=0.02) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), TWO.f(wi, wo), rtol=0.02)


def test_lobes_agree_with_the_oracle(random_directions):
    wi, wo = (random_directions(1000, seed, least_cosine=0.05) for seed in (3, 4))
    wanted = surfaces.bottom("conductor", wi, wo, 0.2, 0.04)
    lobe = GgxFit(np.zeros(3), (Lobe(0.2, 0.04, np.array([1.0, 0.5, 0.0])),))
    # In float32 the denominator of the lobe cancels digits.
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 0], wanted, rtol=1e-3)
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 1], wanted / 2, rtol=1e-3)
    assert (lobe.f(wi, wo)[:, 2] == 0).all()
