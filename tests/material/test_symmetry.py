"""BRDFs that are not isotropic or reciprocal are averaged, and users are warned of the change."""

import warnings

import numpy as np
import pytest
from tests.material.conftest import error

from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.core.probe_pairs import probe_pairs
from urushi.errors import UrushiWarning
from urushi.material.encode import encode
from urushi.material.symmetry import AZIMUTHS, Deviations, asymmetry_pairs
from urushi.material.values import evaluate_source
from urushi.walk import analytic, conductor, diffuse

WI, WO = probe_pairs(192)


def brushed(wi, wo):
    """Reciprocal, not isotropic: brighter where the half vector lies along x."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    return 0.2 + 0.1 * (h[:, 0] ** 2 - h[:, 1] ** 2)


def one_way(wi, wo):
    """Isotropic, not reciprocal: a cosine that was left in."""
    return 0.3 * wo[:, 2]


def handed(wi, wo):
    across = wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]
    return 0.2 + 0.1 * across * (wi[:, 2] - wo[:, 2])


def slightly(wi, wo):
    return 0.3 + 0.03 * wo[:, 2]


def turns(wi, wo, count):
    """Pairs that are turned about the normal by the parts of a turn."""
    return [[rotated(w, k / count) for w in (wi, wo)] for k in range(count)]


def test_symmetric_brdfs_keep_their_bits():
    for surface in (diffuse(0.3), conductor(0.05, (0.9, 0.5, 0.2))):
        values, deviations = evaluate_source(lambda *w, own=surface: analytic.f(own, *w), WI, WO)
        assert np.array_equal(values, analytic.f(surface, WI, WO))
        assert deviations == Deviations()


def test_the_mean_over_the_azimuth_is_encoded():
    values, deviations = evaluate_source(brushed, WI, WO)
    # cos(2 phi) has no mean over an odd number of turns.
    np.testing.assert_allclose(values, 0.2, rtol=1e-5)
    wi, wo = asymmetry_pairs()
    e = np.mean([error(brushed(*sides), 0.2, *sides) for sides in turns(wi, wo, 999)])
    assert deviations.anisotropy == pytest.approx(e, rel=1e-3)
    assert deviations.reciprocity == pytest.approx(0, abs=1e-6)
    # Isotropic, and unlike its mirror image where the elevations differ
    values, deviations = evaluate_source(handed, WI, WO)
    np.testing.assert_allclose(values, 0.2, rtol=1e-5)
    assert deviations.anisotropy > 0.01


def test_the_mean_over_the_exchange_is_encoded():
    values, deviations = evaluate_source(one_way, WI, WO)
    np.testing.assert_allclose(values[:, 0], 0.15 * (WI[:, 2] + WO[:, 2]), rtol=1e-5)
    # These pairs of cosine density differ from the pairs of the measurement: E of 1024 pairs has a
    # statistical error of 2 %.
    wi, wo = cosine_pairs(np.random.default_rng(1), 100_000, lowest_cosine=0.01)
    e = error(one_way(wi, wo), 0.15 * (wi[:, 2] + wo[:, 2]), wi, wo)
    assert deviations.reciprocity == pytest.approx(e, rel=0.08)
    assert deviations.anisotropy == pytest.approx(0, abs=1e-6)


def test_a_narrow_lobe_is_averaged_without_loss():
    """Of a brushed metal: GGX of widths 0.01 and 0.5, against 1,999 turns."""

    def metal(wi, wo):
        h = wi + wo
        slope = h[:, :2] / h[:, 2:]
        lobe = 1 + (slope[:, 0] / 0.01) ** 2 + (slope[:, 1] / 0.5) ** 2
        return (1 / (lobe**2 * (wi[:, 2] + wo[:, 2])))[:, None]

    expected = np.mean([metal(*sides) for sides in turns(WI, WO, 1999)], axis=0)
    found, _ = evaluate_source(metal, WI, WO)
    assert np.abs(found - expected).sum() < 5e-3 * expected.sum()


def test_a_user_is_warned_only_of_large_changes(model):
    with pytest.warns(UrushiWarning, match="encode one_way: the BRDF is not reciprocal"):
        encode(one_way, model)
    with pytest.warns(UrushiWarning, match=r"encode Conductor: the BRDF is anisotropic: .* \d+% "):
        encode(conductor(alpha_u=0.1, alpha_v=0.4, r0=0.9), model)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        encode(slightly, model)
    assert 0 < evaluate_source(slightly, WI, WO)[1].reciprocity < 0.1


def test_functions_are_evaluated_only_above_the_horizon():
    lowest = []

    def f(wi, wo):
        lowest.append(min(wi[:, 2].min(), wo[:, 2].min()))
        return one_way(wi, wo)

    evaluate_source(f, WI, WO)
    assert min(lowest) > 0
    assert len(lowest) == 4 + 2 * AZIMUTHS  # three measurements, one for noise, then all pairs


def test_noise_is_not_taken_for_asymmetry():
    rng = np.random.default_rng(0)

    def noisy(wi, wo):
        return rng.exponential(0.2, len(wi))

    values, deviations = evaluate_source(noisy, WI, WO)
    assert deviations.anisotropy is None and deviations.reciprocity is None
    assert not deviations.warnings()
    # Means of 16 values and more of deviation 0.2 each: 0.05, of which 192 are drawn.
    assert abs(values.mean() - 0.2) < 4 * 0.05 / np.sqrt(192)
    assert np.abs(values - 0.2).max() < 0.3
