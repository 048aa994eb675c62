"""Rows of bottoms and coats: light transport at some of them corrects the network."""

import numpy as np
from tests.untrained import untrained

from urushi.textures import layering


def test_an_isotropic_coat_is_one_of_two_equal_widths(monkeypatch):
    """Over bottoms of two widths; more rows than are transported."""
    monkeypatch.setitem(layering.TRANSPORTED, 2, 2)
    model, rng = untrained(widths=2), np.random.default_rng(0)
    z = 0.2 * rng.normal(size=(4, model.arch.latent))
    z[:, : model.arch.lobe] = 0.2, 0, 0, 1, 1.5, 0, 0.1
    coats = np.tile([0.3, 1.5, 0.5, 1.0, 0.2, 0.3], (4, 1))
    coats[:, 3] = rng.uniform(0.5, 2, 4)
    rows = np.concatenate([z, coats], axis=1).astype(np.float32)
    found, expected = (layering.layer_rows(model, x) for x in (rows[:, :-1], rows))
    np.testing.assert_array_equal(found, expected)
    assert np.isfinite(found).all() and len(np.unique(found, axis=0)) == 4
