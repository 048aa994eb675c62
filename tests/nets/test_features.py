"""Features: exactly symmetric, finite, precise for small half angles; coats without medium."""

import math
import re

import numpy as np

from urushi.core.directions import directions_at_tangent
from urushi.core.probe_pairs import probe_pairs
from urushi.nets.features import (
    COAT_FEATURES,
    COAT_TABLE,
    DIRECTION_FEATURES,
    DIRECTION_TABLE,
    coat_features,
    direction_features,
)


def _raw(features, table):
    return [features[..., i] * scale + mean for i, (_, mean, scale) in enumerate(table)]


def test_direction_features_are_symmetric_bit_for_bit(pairs):
    wi, wo = pairs
    assert np.array_equal(direction_features(wi, wo), direction_features(wo, wi))


def test_direction_features_are_finite_float32(pairs):
    features = direction_features(*pairs)
    assert features.shape == (len(pairs[0]), DIRECTION_FEATURES[1])
    assert features.dtype == np.float32
    assert np.isfinite(features).all()
    assert np.abs(features).max() < 10  # normalised: nothing overwhelms the first layer


def test_direction_features_are_isotropic(pairs):
    wi, wo = (w.astype(np.float64) for w in pairs)
    angle = 0.7
    turn = np.array([
        [math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]
    ])  # fmt: skip
    turned = direction_features(wi @ turn.T, wo @ turn.T)
    # float64 rounding, magnified where ln(tan^2 + 1e-6) is steepest.
    np.testing.assert_allclose(turned, direction_features(wi, wo), atol=1e-6)


def test_features_are_the_documented_functions_of_the_angles():
    # Independent of the un-normalised form in the code: trigonometry on given angles, down to
    # tan theta_h = 0.001, in float32. The absolute rounding of wi + wo is 1e-7, hence 1e-3 in
    # the logarithm of the smallest tangent's square plus 1e-6.
    tan_h, theta_d = np.meshgrid(np.geomspace(1e-3, 1, 20), np.linspace(0, 1.2, 13))
    wi, wo = directions_at_tangent(tan_h.ravel(), theta_d.ravel(), np.full(tan_h.size, 0.9))
    keep = (wi[:, 2] > 0.01) & (wo[:, 2] > 0.01)
    wi, wo, tan_h, d = wi[keep], wo[keep], tan_h.ravel()[keep], theta_d.ravel()[keep]
    h = np.arctan(tan_h)
    raw = _raw(
        direction_features(wi.astype(np.float32), wo.astype(np.float32)).astype(np.float64),
        DIRECTION_TABLE,
    )
    expected = [
        np.log(tan_h**2 + 1e-6), np.sin(h) ** 0.5, np.cos(h), np.cos(d), (1 - np.cos(d)) ** 5,
        0.5 * np.log(wi[:, 2] * wo[:, 2]), np.log(wi[:, 2] + wo[:, 2]),
        np.minimum(wi[:, 2], wo[:, 2]),
    ]  # fmt: skip
    for value, truth, (name, _, _) in zip(raw, expected, DIRECTION_TABLE, strict=True):
        np.testing.assert_allclose(value, truth, atol=2e-3, err_msg=name)


def test_normalisation_suits_the_probes():
    # The probes are spread like the training pairs: mean about 0, deviation about 1.
    features = direction_features(*probe_pairs(4096))
    assert np.abs(features.mean(axis=0)).max() < 0.5
    assert features.std(axis=0).min() > 0.3 and features.std(axis=0).max() < 1.5


def test_coat_without_medium_does_not_depend_on_albedo_and_g():
    albedo, g = (x.astype(np.float32) for x in np.meshgrid(np.linspace(0, 1, 5), [-0.9, 0, 0.9]))
    features = coat_features(np.float32(0.2), np.float32(1.5), albedo, np.float32(0.0), g)
    assert features.shape == (3, 5, COAT_FEATURES[1])
    assert np.array_equal(features, np.broadcast_to(features[0, 0], features.shape))


def test_coat_features_are_finite_to_the_ends_of_their_ranges():
    ends = np.meshgrid([0.01, 1], [0.5, 1, 3], [0, 1], [0, 1e-3, 8, 1e4], [-0.999, 0.999])
    features = coat_features(*(x.astype(np.float32) for x in ends))
    assert np.isfinite(features).all()


def test_coat_features_of_different_coats_differ():
    base = np.array([0.2, 1.5, 0.5, 1.0, 0.3], np.float32)
    reference = coat_features(*base)
    for index in range(5):
        changed = base.copy()
        changed[index] += 0.1
        assert np.abs(coat_features(*changed) - reference).max() > 0.02


def test_coat_features_are_the_documented_functions():
    """The table's formulas as Python, by the names of the parameters."""
    rng = np.random.default_rng(6)
    low, high = [0.01, 0.5, 0, 0, -0.9], [1, 3, 1, 8, 0.9]
    coats = rng.uniform(low, high, (200, 5))
    names = ("alpha", "eta", "albedo", "sigma_t", "g")
    features = coat_features(*coats.T)
    assert features.shape == (200, COAT_FEATURES[1])
    for column, (formula, _, _) in zip(_raw(features, COAT_TABLE), COAT_TABLE, strict=True):
        scope = dict(zip(names, coats.T, strict=True))
        scope |= {"ln": np.log, "exp": np.exp, "sqrt": np.sqrt, "max": np.maximum}
        scope |= {
            "m": 1 - np.exp(-scope["sigma_t"]),
            "s": (scope["eta"] - 1) / (scope["eta"] + 1),
        }
        code = formula.replace("^", "**").replace("ln alpha", "ln(alpha)")
        for word in ("alpha", "eta", "albedo", "sigma_t", "g", "m", "s"):
            code = re.sub(rf"([\w)]) (?={word}\b)", r"\1 * ", code)
        code = re.sub(r"([\w)]) (?=\(|sqrt)", r"\1 * ", code)
        np.testing.assert_allclose(column, eval(code, scope), atol=1e-12, err_msg=formula)
