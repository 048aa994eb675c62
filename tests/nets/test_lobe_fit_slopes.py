"""Derivatives of fitted lobes by the values that they are fitted to."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.lobe_fit_slopes import fit_slopes


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def glossy(rng, count, alpha=(0.05, 0.6)):
    """Values (N, 192) of diffuse surfaces under one lobe, and what a share more of it adds.

    The change is that of ln alpha, of both factors and of the diffuse term, by random amounts.
    """
    width = rng.uniform(*alpha, count)[:, None]
    factors, diffuse = rng.uniform(0.05, 0.6, (2, count, 1)), rng.uniform(0.05, 0.5, (count, 1))
    rates = rng.normal(size=(4, count, 1))
    pairs = [w.astype(np.float64) for w in probe_pairs(192)]
    fifth = (1 - lobe.cosine_to_facet(*pairs)) ** 5

    def f(t):
        normal, grazing = (x * (1 + t * r) for x, r in zip(factors, rates[1:3], strict=True))
        shape = lobe.shape(width * np.exp(t * rates[0]), *pairs)
        lambert = diffuse * (1 + t * rates[3]) / np.pi
        return shape * (normal * (1 - fifth) + grazing * fifth) + lambert

    numbers = np.concatenate([width, *factors], axis=-1)
    rate = np.concatenate([width * rates[0], factors[0] * rates[1], factors[1] * rates[2]], axis=-1)
    return f(0.0), (f(1e-6) - f(-1e-6)) / 2e-6, numbers, rate


def test_fitted_lobes_follow_the_values(rng):
    """Of BRDFs that are one lobe over a diffuse surface, the fitted numbers are exact."""
    f, df, numbers, rate = glossy(rng, 30)
    lobes = np.tile(np.array(lobe.NO_LOBE), (30, 1))
    lobes[:, :3] = numbers
    found = (fit_slopes(f, lobes) @ df[..., None])[..., 0]
    np.testing.assert_allclose(found, rate, rtol=1e-3, atol=1e-3)


def test_slopes_of_fitted_lobes_against_fits(rng):
    """Of values with deviations of 3 %, for which no lobe is exact.

    The fit ends after some steps, and its function has kinks: medians agree, not every row.
    """
    f, df, _, _ = glossy(rng, 60)
    f = f * np.exp(0.03 * rng.normal(size=f.shape))
    step = 1e-2
    change = (fit_lobes(f + step * df) - fit_lobes(f - step * df))[:, :3] / (2 * step)
    found = (fit_slopes(f, fit_lobes(f)) @ df[..., None])[..., 0]
    error = np.abs(found - change) / (np.abs(change) + 0.02)
    assert (np.median(error, axis=0) < 0.05).all()
    assert (np.quantile(error, 0.8, axis=0) < 0.3).all()


def test_surfaces_without_a_lobe_have_finite_slopes(rng):
    f = np.stack([np.zeros(192), np.full(192, 0.1), rng.random(192)])
    assert np.isfinite(fit_slopes(f, fit_lobes(f))).all()
