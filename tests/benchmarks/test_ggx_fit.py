"""Fitted lobes: exact recovery, agreement with the Dr.Jit physics, and stability under noise."""

import numpy as np
import pytest
from benchmarks.rivals.ggx_fit import GgxFit, Lobe, fit

ONE = GgxFit(np.array([0.3, 0.2, 0.1]), (Lobe(0.08, 0.04, np.array([1.0, 0.9, 0.8])),))
TWO = GgxFit(ONE.diffuse, (*ONE.lobes, Lobe(0.3, 0.3, np.array([0.2, 0.3, 0.5]))))


def test_two_lobes_are_found_again(random_directions):
    found = fit(TWO.f, 2, "root")
    assert sorted(lobe.alpha for lobe in found.lobes) == pytest.approx([0.08, 0.3], rel=0.01)
    wi, wo = (random_directions(500, seed, least_cosine=0.02) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), TWO.f(wi, wo), rtol=0.02)


def test_lobes_agree_with_those_of_the_random_walk(random_directions):
    import drjit as dr
    import drjit.llvm as jit

    from urushi.core import microfacet

    wi, wo = (random_directions(1000, seed, least_cosine=0.05) for seed in (3, 4))
    walked, cosine = microfacet.reflection_lobe(jit.Array3f(wi.T), jit.Array3f(wo.T), 0.2)
    wanted = np.array(walked * dr.lerp(0.04, 1.0, (1 - cosine) ** 5))
    lobe = GgxFit(np.zeros(3), (Lobe(0.2, 0.04, np.array([1.0, 0.5, 0.0])),))
    # Both are float32, where the lobe's denominator cancels digits.
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 0], wanted, rtol=1e-3)
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 1], wanted / 2, rtol=1e-3)
    assert (lobe.f(wi, wo)[:, 2] == 0).all()
