"""Neural BTFs of single BRDFs: sizes, a constant BRDF, sets of measurements, numbers of a code."""

import numpy as np
import pytest
from benchmarks.rivals import rainer
from benchmarks.rivals.ggx_fit import GgxFit, Lobe

from urushi.core.direction_sets import cosine_pairs, half_angle_pairs


def relative(found, wanted):
    return np.abs(found - wanted).mean() / wanted.mean()


@pytest.mark.parametrize(("latent", "weights"), [(8, 35_725), (32, 38_269)])
def test_decoders_have_the_weights_of_their_layers(latent, weights):
    decoder = rainer.initial(np.random.default_rng(0), rainer.decoder_sizes(latent))
    assert rainer.size(decoder) == weights
    assert len(decoder) == rainer.LAYERS + 1


def test_a_lambertian_is_learned_almost_exactly():
    rho = np.array([0.2, 0.5, 0.8])
    learned = rainer.train(
        lambda wi, wo: np.broadcast_to(rho / np.pi, (len(wi), 3)), passes=8, samples=20_000
    )
    wi, wo = cosine_pairs(np.random.default_rng(1), 2000, lowest_cosine=0.02)
    # It has no closed form in ReLUs of the loss's compressed values; 1 % is a tenth of what the
    # best constant leaves of an ordinary BRDF.
    assert relative(learned.f(wi, wo), np.broadcast_to(rho / np.pi, (len(wi), 3))) < 0.01


def brdfs(rng, count):
    """GGX lobes over diffuse bases of random colours, and their values (M, P, 3) at pairs."""
    fits = [
        GgxFit(rng.uniform(0, 0.8, 3), (Lobe(a, 0.04, rng.uniform(0.5, 1.5, 3)),))
        for a in rng.uniform(0.15, 0.6, count)
    ]
    pairs = 256
    wi, wo = (w.reshape(count, pairs, 3) for w in half_angle_pairs(rng, count * pairs))
    values = np.stack([fit.f(*both) for fit, *both in zip(fits, wi, wo, strict=True)])
    return fits, wi, wo, values


def test_codes_are_of_sets_of_measurements():
    rng = np.random.default_rng(2)
    first, second = rainer.initial(rng, (7, 128, 128)), rainer.initial(rng, (128, 128, 32))
    decoder = rainer.initial(rng, rainer.decoder_sizes(rainer.LATENT_2020))
    networks = rainer.Unified(first, second, decoder)
    _, *sets = brdfs(rng, 1)
    one, shuffled = (
        networks.encode(*(array[0][order] for array in sets)).code
        for order in (np.arange(256), rng.permutation(256))
    )
    assert one.shape == (32,)
    np.testing.assert_allclose(shuffled, one, atol=1e-5)  # rounding of a mean
