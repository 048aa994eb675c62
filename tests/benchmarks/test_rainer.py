"""Neural BTFs of single BRDFs: sizes, a constant BRDF, sets of measurements, numbers of a code."""

import numpy as np
import pytest
from benchmarks.measures import half_angle_pairs
from benchmarks.rivals import rainer
from benchmarks.rivals.nbrdf import size

from urushi.core.direction_sets import cosine_pairs


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
