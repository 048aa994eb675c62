"""Proposals of codes: valid for any code, and close to f cos where f is known."""

import numpy as np
import pytest
from tests import mixtures
from tests.directions import at_cosines, in_plane
from tests.untrained import untrained

from urushi.core import microfacet
from urushi.core.direction_sets import cosine_pairs
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.weights import anisotropic_model, default_model


@pytest.mark.parametrize("widths", [1, 2])
def test_weights_are_a_mixture_for_any_code(widths):
    model = untrained(widths=widths)
    rng = np.random.default_rng(1)
    z = rng.normal(0, 5, (200, model.arch.latent)).astype(np.float32)
    z[:, model.arch.lobe] = rng.choice([-100, -3, 0, 30], 200)  # no rest, and unlike materials
    z[:, : model.arch.lobe] = [(0.2, 0.1, 0.4, 0.5, 1.5, 1.0, 0.05)[: model.arch.lobe]] * 200
    wi, _ = cosine_pairs(rng, 200, lowest_cosine=1e-4)
    mixture = model.networks.proposal(z, wi.astype(np.float32))
    weights = mixtures.weights(mixture)
    assert weights.shape == (200, len(proposal.ALPHAS) + 2)
    np.testing.assert_allclose(weights.sum(axis=-1), 1, atol=1e-6)
    assert (weights >= 0).all()
    assert (weights[:, -1] > proposal.MIN_COSINE_SHARE - 1e-6).all()
    for alpha, known in zip(mixture.alphas[1:], proposal.ALPHAS, strict=True):
        np.testing.assert_allclose(np.sqrt(microfacet.product(alpha)), known, rtol=1e-5)


def test_the_gain_scales_the_rest_alone():
    """Without a lobe, weights do not depend on the gain; with one, it gets what the rest loses."""
    networks = default_model().networks
    none = np.array(lobes.no_lobe(), np.float32)
    f = 0.02 + lobes.f(np.array((0.2, 0.9, 1, 0, 1.5, 0), np.float32), *networks.pairs())
    z = np.repeat(networks.encode(f[None].astype(np.float32), none[None]), 2, axis=0)
    z[1, len(none)] -= 2
    wi = in_plane(np.array([0.0, 50.0, 85.0]))
    weights = mixtures.weights(networks.proposal(z[:, None], wi))
    np.testing.assert_allclose(weights[0], weights[1], atol=1e-5)
    z[:, : len(none)] = (0.1, 0, 0, 1, 1.5, 0)
    weights = mixtures.weights(networks.proposal(z[:, None], wi))
    assert (weights[1, :, 0] > weights[0, :, 0]).all()


def test_a_smooth_metal_is_its_own_lobe():
    networks, lobe = default_model().networks, np.array([(0.05, 1, 1, 0, 1.5, 0)], np.float32)
    z = np.concatenate([lobe, networks.empty_rest()[None]], axis=1)
    weights = mixtures.weights(networks.proposal(z, in_plane(np.array([0.0, 45.0, 80.0]))))
    np.testing.assert_allclose(weights[:, 0], 1 - proposal.MIN_COSINE_SHARE, atol=1e-3)


def variation(networks, f, lobe, wi: np.ndarray) -> float:
    """That of `mixtures` for the code of f over a lobe."""
    z = networks.encode(f(*networks.pairs())[None].astype(np.float32), lobe[None])[0]
    return mixtures.variation(networks, z, f, wi)


@pytest.mark.parametrize(
    ("lobe", "rest", "most"),
    [
        ((0.1, 0, 0, 1, 1.5, 0), 0.1, 0.5),  # plastic: a coat over a Lambertian
        ((0.02, 0, 0, 1, 1.5, 0), 0.25, 0.5),
        ((0.3, 0.9, 1, 0, 1.5, 0), 0.0, 0.5),  # bare metals
        ((0.7, 0.9, 1, 0, 1.5, 0), 0.0, 0.8),
        (lobes.no_lobe(), 0.2, 0.25),  # a Lambertian
    ],
)
def test_the_variance_of_samples_is_small(lobe, rest, most):
    lobe, wi = np.array(lobe, np.float32), in_plane(np.arange(0, 86, 5.0)).astype(float)
    found = variation(default_model().networks, lambda *w: lobes.f(lobe, *w) + rest, lobe, wi)
    assert found < most


@pytest.mark.parametrize("widths", [(0.1, 0.1), (0.08, 0.3), (0.3, 0.08)])
def test_a_brushed_rest_is_sampled_by_stretched_lobes(widths):
    """A metal that is a rest, under the lobe of a coat; round lobes would have one and more."""
    coat = np.array([0.1, 0, 0, 1, 1.5, 0, 0.1], np.float32)
    metal = np.array([widths[0], 0.8, 1, 0, 1.5, 0, widths[1]], np.float32)
    theta, phi = np.radians([[10, 40, 70], [0, 45, 90]])
    wi = at_cosines(np.cos(theta), phi).astype(float)

    def f(*w):
        return lobes.f(coat, *w) + lobes.f(metal, *w) + 0.01

    assert variation(anisotropic_model().networks, f, coat, wi) < 0.5
