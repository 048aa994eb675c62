"""The analytic lobe of codes: f is lobe plus decoder, coats become lobes."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.nets import decoder, lobe, sampler
from urushi.nets.features import direction_features
from urushi.nets.networks import UrushiNetworks


@pytest.fixture
def own(small):
    arch, params = small
    return UrushiNetworks(params, arch)


@pytest.fixture
def codes(draw_codes):
    return draw_codes(30, np.random.default_rng(0)).astype(np.float32)


def test_f_is_the_lobe_and_the_decoder(own, codes, pairs):
    wi, wo = pairs
    f = own.f(codes[:, None], wi, wo)
    rest = decoder.decode(own.params, own.arch, codes[:, None, 6:], direction_features(wi, wo))
    np.testing.assert_array_equal(f, lobe.f(codes[:, None, :6], wi, wo) + rest)
    assert f.dtype == np.float32
    assert (f > 0).all() and np.isfinite(f).all()


def test_the_interface_of_a_coat_is_the_lobe_of_the_result(own, codes):
    rng = np.random.default_rng(2)
    low, high = [0.01, 0.5, 0, 0, -0.9], [1, 3, 1, 8, 0.9]
    coat = CoatParameters(*rng.uniform(low, high, (30, 5)).astype(np.float32).T)
    coated = own.layer(codes, coat)
    assert coated.dtype == np.float32 and coated.shape == codes.shape
    np.testing.assert_array_equal(coated[:, :6], lobe.of_coat(coat.alpha, coat.eta))


def test_what_lies_below_a_coat_matters_by_its_reflection(own, codes):
    """Lobes that reflect nothing are the same bottom, whatever their width."""
    coat = CoatParameters(*(np.float32(x) for x in (0.1, 1.5, 0.5, 1, 0)))
    bare = np.array(codes)
    bare[:, :6] = lobe.NO_LOBE
    narrow = np.array(bare)
    narrow[:, 0] = 0.02
    np.testing.assert_array_equal(own.layer(bare, coat), own.layer(narrow, coat))
    mirror = np.array(bare)
    mirror[:, :6] = lobe.of_coat(np.float32(0.02), np.float32(2.5))
    assert np.abs(own.layer(bare, coat) - own.layer(mirror, coat)).max() > 0.01


def test_a_known_lobe_is_kept_and_taken_from_the_values(own, codes):
    """The encoder sees what the lobe leaves, so that it does not see the lobe."""
    top = lobe.f(codes[:, None, :6], *own.pairs())
    rest = np.full_like(top, 0.1)
    encoded = own.encode(rest + top, codes[:, :6])
    np.testing.assert_array_equal(encoded[:, :6], codes[:, :6])
    bare = own.encode(rest, np.array(lobe.NO_LOBE, np.float32))
    # Sharp lobes of some hundred per sr leave the rest with rounding errors of 1e-5.
    np.testing.assert_allclose(encoded[:, 6:], bare[:, 6:], atol=5e-3)


def test_the_proposal_is_normalised_and_has_the_codes_own_lobe(own, codes):
    wi = np.array([[0.6, 0, 0.8]], np.float32)
    weights, alphas = own.proposal(codes, wi)
    assert weights.shape == (30, 3) and alphas.shape == (30, 2)
    np.testing.assert_array_equal(alphas[:, 0], codes[:, 0])
    np.testing.assert_allclose(weights.sum(axis=-1), 1, atol=1e-6)
    assert (weights > 0).all()
    assert (weights[:, -1] >= sampler.MIN_COSINE_SHARE).all()
