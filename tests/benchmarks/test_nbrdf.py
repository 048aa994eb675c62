"""Neural BRDFs of 675 weights: form, symmetry, and agreement with the published fits' generator."""

import numpy as np
from benchmarks.rivals import nbrdf


def test_reciprocal_positive_and_turned_with_the_surface(random_directions):
    network = nbrdf.unpacked(np.random.default_rng(1).normal(0, 0.4, nbrdf.SIZE))
    wi, wo = (random_directions(300, seed) for seed in (1, 2))
    f = network.f(wi, wo)
    assert f.shape == (300, 3)
    assert (f >= 0).all()
    assert f.max() > 0
    np.testing.assert_array_equal(f, network.f(wo, wi))
    cos, sin = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]], np.float32)
    np.testing.assert_allclose(network.f(wi @ turn.T, wo @ turn.T), f, rtol=1e-3, atol=1e-5)


def test_agrees_with_the_published_fits(tool, random_directions):
    fits = np.load(tool.FITS)
    x = tool.merl_grid()[::997]
    angles = np.arctan2(x[:, 0], x[:, 2]), np.arccos(x[:, 5]), np.arctan2(x[:, 4], x[:, 3])
    np.testing.assert_allclose(nbrdf.vectors(*angles), x, atol=1e-9)
    for name in ("chrome", "red-fabric"):
        weights = fits[name].astype(np.float64)
        np.testing.assert_allclose(
            nbrdf.unpacked(weights).at(x), tool.network(weights, x), rtol=1e-6, atol=1e-9
        )
