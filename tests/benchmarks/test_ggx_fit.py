"""Fitted lobes: exact recovery, agreement with the Dr.Jit physics, and stability under noise."""

import sys

import numpy as np
import pytest
from benchmarks.rivals import ggx_fit
from benchmarks.rivals.ggx_fit import LOSSES, MEASURES, GgxFit, Lobe, candidates, fit

from urushi.errors import ParameterError, PlatformError

ONE = GgxFit(np.array([0.3, 0.2, 0.1]), (Lobe(0.08, 0.04, np.array([1.0, 0.9, 0.8])),))
TWO = GgxFit(ONE.diffuse, (*ONE.lobes, Lobe(0.3, 0.3, np.array([0.2, 0.3, 0.5]))))


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("loss", LOSSES)
def test_a_lobe_is_found_again(loss, measure, random_directions):
    found = fit(ONE.f, 1, loss, measure)
    assert found.lobes[0].alpha == pytest.approx(0.08, rel=1e-3)
    wi, wo = (random_directions(500, seed, least_cosine=0.02) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), ONE.f(wi, wo), rtol=0.01)


def test_two_lobes_are_found_again(random_directions):
    found = fit(TWO.f, 2, "root")
    assert sorted(lobe.alpha for lobe in found.lobes) == pytest.approx([0.08, 0.3], rel=0.01)
    wi, wo = (random_directions(500, seed, least_cosine=0.02) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), TWO.f(wi, wo), rtol=0.02)


def test_a_grey_lambertian_surface_is_fitted(random_directions):
    found = fit(lambda wi, wo: np.full((len(wi), 1), 0.5 / np.pi), 1, "log")
    wi, wo = (random_directions(200, seed, least_cosine=0.2) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), 0.5 / np.pi, rtol=0.01)


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


def test_reciprocal_and_black_below_the_horizon(random_directions):
    wi, wo = (random_directions(100, seed) for seed in (5, 6))
    np.testing.assert_allclose(TWO.f(wi, wo), TWO.f(wo, wi), rtol=1e-5)
    assert (TWO.f(wi, wo * np.float32([1, 1, -1])) == 0).all()


def test_the_derivatives_are_those_of_the_residuals():
    wi, wo = (w[::50].astype(np.float64) for w in ggx_fit.pairs())
    for loss in LOSSES:
        problem = ggx_fit._Problem(
            ggx_fit.Geometry.of(wi, wo), TWO._f(wi, wo), loss, np.ones(len(wi))
        )
        x = problem.initial((0.05, 0.4))
        for i, column in enumerate(problem.jacobian(x).T):
            step = np.eye(len(x))[i] * 1e-5
            slope = (problem.residuals(x + step) - problem.residuals(x - step)) / 2e-5
            np.testing.assert_allclose(column, slope, rtol=1e-3, atol=1e-5 * np.abs(slope).max())


def test_solid_angles_integrate_over_pairs():
    # The mean cosine theta_i over pairs of cosine density on both sides is 2/3.
    wi, _ = ggx_fit.pairs()
    weight = ggx_fit.solid_angles()
    assert np.average(wi[:, 2], weights=weight) == pytest.approx(2 / 3, abs=0.01)


def test_candidates_are_all_choices_up_to_the_number_of_lobes(monkeypatch):
    monkeypatch.setattr(ggx_fit, "fit", lambda f, *choice: choice)
    assert set(candidates(ONE.f, 1)) == {(1, loss, m) for loss in LOSSES for m in MEASURES}
    assert set(candidates(ONE.f, 2)) == {
        (count, loss, m) for count in (1, 2) for loss in LOSSES for m in MEASURES
    }


def test_what_cannot_be_fitted():
    with pytest.raises(ParameterError, match="cannot fit 3 lobes by the loss 'log'; fit 1 or 2"):
        fit(ONE.f, 3)
    with pytest.raises(ParameterError, match="by one of linear, log, root"):
        fit(ONE.f, 1, "cosine")


def test_a_missing_scipy_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(PlatformError, match=r"install it: pip install .*'scipy<2,>=1.14'"):
        fit(ONE.f)
