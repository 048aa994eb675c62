"""Proposals of codes: valid for any code, and close to f cos where f is known."""

import numpy as np
import pytest
from tests import mixtures
from tests.directions import in_plane
from tests.untrained import untrained

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY
from urushi.core.quadrature import half_vector_rule
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


def test_the_lobes_of_two_widths_are_stretched():
    """GGX of the widths a / s and a s is round to half vectors (h_x s, h_y / s, h_z)."""
    lobes_of_code = proposal.widths_of(Widths(0.1, 0.2), np.log(2.0), NUMPY)
    for alpha, width in zip(proposal.ALPHAS, lobes_of_code[1:], strict=True):
        assert width.v == pytest.approx(4 * width.u)
        assert width.u * width.v == pytest.approx(alpha**2)
    assert proposal.widths_of(0.1, 0.0, NUMPY) == [0.1, *proposal.ALPHAS]


def test_a_smooth_metal_is_its_own_lobe():
    model = default_model()
    z = np.zeros((1, model.arch.latent), np.float32)
    z[0, : model.arch.lobe] = (0.05, 1, 1, 0, 1.5, 0)
    z[0, model.arch.lobe :] = model.networks.empty_rest()
    weights = mixtures.weights(model.networks.proposal(z, in_plane(np.array([0.0, 45.0, 80.0]))))
    np.testing.assert_allclose(weights[:, 0], 1 - proposal.MIN_COSINE_SHARE, atol=1e-3)


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
    """Coefficient of variation of f cos / pdf, by quadrature; a cosine lobe has up to 25."""
    networks = default_model().networks
    lobe = np.array(lobe, np.float32)
    wi, wo = networks.pairs()
    z = networks.encode((lobes.f(lobe, wi, wo) + rest)[None].astype(np.float32), lobe[None])[0]
    wi = in_plane(np.arange(0, 86, 5.0))
    wo, share = half_vector_rule(wi)
    f_cos = (lobes.f(lobe, wi[:, None], wo) + rest) * wo[..., 2]
    pdf = mixtures.pdf(networks.proposal(z, wi[:, None]), wi[:, None].astype(float), wo)
    second = np.sum(f_cos**2 / pdf * share, axis=-1) / np.sum(f_cos * share, axis=-1) ** 2
    assert np.sqrt(np.mean(second - 1)) < most


@pytest.mark.parametrize("widths", [(0.1, 0.1), (0.08, 0.3), (0.3, 0.08)])
def test_a_brushed_rest_is_sampled_by_stretched_lobes(widths):
    """A metal that is a rest, under the lobe of a coat; round lobes would have one and more."""
    networks = anisotropic_model().networks
    coat = np.array([0.1, 0, 0, 1, 1.5, 0, 0.1], np.float32)
    metal = np.array([widths[0], 0.8, 1, 0, 1.5, 0, widths[1]], np.float32)

    def f(wi, wo):
        return lobes.f(coat, wi, wo) + lobes.f(metal, wi, wo) + 0.01

    z = networks.encode(f(*networks.pairs())[None].astype(np.float32), coat[None])[0]
    theta, phi = np.radians([[10, 40, 70], [0, 45, 90]])
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    wo, share = half_vector_rule(wi, anisotropic=True)
    f_cos = f(wi[:, None], wo) * wo[..., 2]
    mixture = networks.proposal(z, wi[:, None].astype(np.float32))
    pdf = mixtures.pdf(mixture, wi[:, None], wo)
    second = np.sum(f_cos**2 / pdf * share, axis=-1) / np.sum(f_cos * share, axis=-1) ** 2
    assert np.sqrt(np.mean(second - 1)) < 0.5
