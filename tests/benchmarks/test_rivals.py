"""Representations of single BRDFs: fitted lobes, neural BRDFs and BTFs."""

import numpy as np
import pytest
from benchmarks.measures import half_angle_pairs
from benchmarks.rivals import nbrdf, rainer
from benchmarks.rivals.ggx_fit import GgxFit, fit
from benchmarks.rivals.nbrdf import size
from tests.directions import above
from tests.oracles import surfaces

from urushi.core.direction_sets import cosine_pairs

COLOURS = np.array([[1.0, 0.9, 0.8], [0.2, 0.3, 0.5]])
TWO = GgxFit(np.array([0.3, 0.2, 0.1]), np.array([0.08, 0.3]), np.array([0.04, 0.3]), COLOURS)


def test_two_lobes_are_found_again():
    found = fit(TWO.f, 2, "root")
    assert sorted(found.alpha) == pytest.approx([0.08, 0.3], rel=0.01)
    wi, wo = (above(500, seed, least_cosine=0.02) for seed in (1, 2))
    np.testing.assert_allclose(found.f(wi, wo), TWO.f(wi, wo), rtol=0.02)


def test_lobes_agree_with_the_oracle():
    wi, wo = (above(1000, seed, least_cosine=0.05) for seed in (3, 4))
    wanted = surfaces.bottom("conductor", wi, wo, 0.2, 0.04)
    lobe = GgxFit(np.zeros(3), *map(np.array, ([0.2], [0.04], [[1.0, 0.5, 0.0]])))
    # In float32 the denominator of the lobe cancels digits.
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 0], wanted, rtol=1e-3)
    np.testing.assert_allclose(lobe.f(wi, wo)[:, 1], wanted / 2, rtol=1e-3)
    assert (lobe.f(wi, wo)[:, 2] == 0).all()


def test_reciprocal_positive_and_turned_with_the_surface():
    network = nbrdf.unpacked(np.random.default_rng(1).normal(0, 0.4, nbrdf.SIZE))
    wi, wo = (above(300, seed) for seed in (1, 2))
    f = network.f(wi, wo)
    assert f.shape == (300, 3)
    assert (f >= 0).all()
    assert f.max() > 0
    np.testing.assert_array_equal(f, network.f(wo, wi))
    cos, sin = np.cos(0.7), np.sin(0.7)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]], np.float32)
    np.testing.assert_allclose(network.f(wi @ turn.T, wo @ turn.T), f, rtol=1e-3, atol=1e-5)


def test_agrees_with_the_published_fits(tool):
    fits = np.load(tool.FITS)
    x = tool.merl_grid()[::997]
    angles = np.arctan2(x[:, 0], x[:, 2]), np.arccos(x[:, 5]), np.arctan2(x[:, 4], x[:, 3])
    np.testing.assert_allclose(nbrdf.vectors(*angles), x, atol=1e-9)
    for name in ("chrome", "red-fabric"):
        weights = fits[name].astype(np.float64)
        np.testing.assert_allclose(
            nbrdf.unpacked(weights).at(x), tool.network(weights, x), rtol=1e-6, atol=1e-9
        )


@pytest.mark.parametrize(("latent", "weights"), [(8, 35_725), (32, 38_269)])
def test_decoders_have_the_weights_of_their_layers(latent, weights):
    assert size(rainer.decoder(np.random.default_rng(0), latent)) == weights


def test_a_lambertian_is_learned_almost_exactly():
    rho = np.array([0.2, 0.5, 0.8])

    def f(wi, wo):
        return np.broadcast_to(rho / np.pi, (len(wi), 3))

    learned = rainer.train(f, passes=8, samples=20_000)
    pairs = cosine_pairs(np.random.default_rng(1), 2000, lowest_cosine=0.02)
    # It has no closed form in ReLUs of the loss's compressed values; 1 % is a tenth of what the
    # best constant leaves of an ordinary BRDF.
    assert np.abs(learned.f(*pairs) - f(*pairs)).mean() < 0.01 * f(*pairs).mean()


def test_codes_are_of_sets_of_measurements():
    rng, networks = np.random.default_rng(2), rainer.untrained()
    wi, wo = half_angle_pairs(rng, 256)
    values = wi[:, 2:] * wo[:, 2:] * [0.2, 0.5, 0.8]
    one, shuffled = (
        networks.encode(wi[order], wo[order], values[order]).code
        for order in (np.arange(256), rng.permutation(256))
    )
    assert one.shape == (32,)
    np.testing.assert_allclose(shuffled, one, atol=1e-5)  # rounding of a mean
