"""Features of coats: finite, and the documented functions."""

import re

import numpy as np

from urushi.nets.features import COAT_TABLE, coat_features


def test_coat_features_are_the_documented_functions():
    """The table's formulas as Python, by the names of the parameters."""
    rng = np.random.default_rng(6)
    low, high = [0.01, 0.5, 0, 0, -0.9], [1, 3, 1, 8, 0.9]
    coats = rng.uniform(low, high, (200, 5))
    coats[:20, 3] = 0  # without a medium
    ends = np.meshgrid([0.01, 1], [0.5, 1, 3], [0, 1], [0, 1e-3, 8, 1e4], [-0.999, 0.999])
    coats = np.concatenate([coats, np.stack([x.ravel() for x in ends], axis=-1)])
    scope = dict(zip(("alpha", "eta", "albedo", "sigma_t", "g"), coats.T, strict=True))
    scope |= {"ln": np.log, "exp": np.exp, "sqrt": np.sqrt, "max": np.maximum}
    scope["m"] = 1 - np.exp(-scope["sigma_t"])
    scope["s"] = (scope["eta"] - 1) / (scope["eta"] + 1)
    features = coat_features(*coats.T)
    assert np.isfinite(features).all()
    assert np.isfinite(coat_features(*coats.astype(np.float32).T)).all()
    for column, (formula, mean, scale) in zip(features.T, COAT_TABLE, strict=True):
        code = formula.replace("^", "**").replace("ln alpha", "ln(alpha)")
        for word in ("alpha", "eta", "albedo", "sigma_t", "g", "m", "s"):
            code = re.sub(rf"([\w)]) (?={word}\b)", r"\1 * ", code)
        code = re.sub(r"([\w)]) (?=\(|sqrt)", r"\1 * ", code)
        found = column * scale + mean
        np.testing.assert_allclose(found, eval(code, scope), atol=1e-12, err_msg=formula)
