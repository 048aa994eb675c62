"""Features of coats: finite, the documented functions; coats without medium."""

import re

import numpy as np

from urushi.nets.features import COAT_FEATURES, COAT_TABLE, coat_features


def _raw(features, table):
    return [features[..., i] * scale + mean for i, (_, mean, scale) in enumerate(table)]


def test_coat_without_medium_does_not_depend_on_albedo_and_g():
    albedo, g = (x.astype(np.float32) for x in np.meshgrid(np.linspace(0, 1, 5), [-0.9, 0, 0.9]))
    features = coat_features(np.float32(0.2), np.float32(1.5), albedo, np.float32(0.0), g)
    assert features.shape == (3, 5, COAT_FEATURES[1])
    assert np.array_equal(features, np.broadcast_to(features[0, 0], features.shape))


def test_coat_features_are_finite_to_the_ends_of_their_ranges():
    ends = np.meshgrid([0.01, 1], [0.5, 1, 3], [0, 1], [0, 1e-3, 8, 1e4], [-0.999, 0.999])
    features = coat_features(*(x.astype(np.float32) for x in ends))
    assert np.isfinite(features).all()


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
