"""Properties of the networks for any weights: reciprocity, positivity, broadcasting.

Decoder and encoder see the 18 numbers of a code that follow its lobe.
"""

import numpy as np
import pytest

from urushi.nets import decoder, encoder, layerer, sampler
from urushi.nets.architecture import ACTIVATIONS, SCALE, Architecture, init
from urushi.nets.features import direction_features
from urushi.nets.lobe import NO_LOBE
from urushi.nets.mlp import activate, linear, with_slope
from urushi.nets.networks import UrushiNetworks


def test_decoder_is_reciprocal_bit_for_bit_positive_and_finite(networks, pairs):
    arch, params = networks
    wi, wo = pairs
    z = np.random.default_rng(2).normal(size=(20, 1, 18)).astype(np.float32) * 10
    f = decoder.decode(params, arch, z, direction_features(wi, wo)[None])
    assert f.shape == (20, len(wi))
    assert np.array_equal(f, decoder.decode(params, arch, z, direction_features(wo, wi)[None]))
    assert (f > 0).all() and np.isfinite(f).all()


def test_decoder_broadcasts_codes_over_directions(networks, pairs):
    arch, params = networks
    z = np.random.default_rng(3).normal(size=(4, 18)).astype(np.float32)
    features = direction_features(*pairs)[:50]
    together = decoder.decode(params, arch, z[:, None], features[None])
    # Products of other shapes may add up in another order: float32 rounding, times the gain of 8.
    for row, code in enumerate(z):
        alone = decoder.decode(params, arch, np.tile(code, (50, 1)), features)
        np.testing.assert_allclose(together[row], alone, rtol=1e-4)


def test_all_codes_at_all_directions_decode_like_each_alone(networks, pairs):
    arch, params = networks
    z = np.random.default_rng(3).normal(size=(5, 18)).astype(np.float32)
    features = direction_features(*pairs)[:50]
    together = decoder.decode_all(params, arch, z, features)
    # The same sums in another layout: float32 rounding, times the gain of 8.
    alone = decoder.decode(params, arch, z[:, None], features)
    np.testing.assert_allclose(together, alone, rtol=1e-4)


def test_few_bottoms_are_layered_as_many(networks):
    arch, params = networks
    rng = np.random.default_rng(6)
    z = rng.uniform(0.1, 1, (40, arch.latent)).astype(np.float32)
    coat = tuple(np.float32([value]) for value in (0.1, 1.5, 0.8, 1.0, 0.5))
    many = layerer.layer(params, arch, z, coat)
    np.testing.assert_allclose(layerer.layer(params, arch, z[:3], coat), many[:3], atol=1e-5)


def test_code_scales_and_shifts_the_response_of_the_first_layer(networks, pairs):
    # What a renderer computes once for a constant material: everything but the response.
    _, params = networks
    rng = np.random.default_rng(4)
    z = rng.normal(size=(7, 17)).astype(np.float32)
    x = direction_features(*pairs)[:7]
    plain = linear(params, "decoder.0", np.concatenate([z, x], axis=-1))
    unscaled = decoder.first_layer(params | {SCALE: np.zeros_like(params[SCALE])}, z, x)
    np.testing.assert_allclose(unscaled, plain, atol=1e-5)
    scale = rng.normal(size=params[SCALE].shape).astype(np.float32)
    scaled = decoder.first_layer(params | {SCALE: scale}, z, x)
    expected = plain + (z @ scale) * (x @ params["decoder.0.weight"][17:])
    np.testing.assert_allclose(scaled, expected, rtol=1e-4, atol=1e-4)


def test_encoder_statistics_normalise_their_data():
    arch = Architecture(probes=64)
    rng = np.random.default_rng(5)
    f = np.exp(rng.uniform(-5, 5, (500, 64)) * np.linspace(0, 1, 64)).astype(np.float32)
    params = init(arch, 0) | encoder.input_statistics(f)
    mean, scale = params["encoder.input_mean"], params["encoder.input_scale"]
    x = (encoder.log_values(f) - mean) / scale
    np.testing.assert_allclose(x.mean(axis=0), 0, atol=1e-4)
    np.testing.assert_allclose(x.std(axis=0)[10:], 1, atol=1e-4)
    assert (scale >= 0.0999).all()  # constant probes do not blow up


def test_encoder_is_finite_for_black_and_very_bright_materials(networks):
    arch, params = networks
    f = np.stack([np.zeros(192), np.full(192, 1e-30), np.full(192, 1e6)]).astype(np.float32)
    assert np.isfinite(encoder.encode(params, arch, f)).all()


def test_layerer_without_output_changes_the_lobe_alone(networks, draw_codes):
    arch, params = networks
    silent = params | {"layerer.3.weight": np.zeros((192, 18), np.float32)}
    z = draw_codes(9, np.random.default_rng(6)).astype(np.float32)
    coat = tuple(np.full(9, x, np.float32) for x in (0.1, 1.5, 0.5, 1, 0))
    assert np.array_equal(layerer.layer(silent, arch, z, coat)[:, 6:], z[:, 6:])


def test_sampler_gives_a_mixture(networks, draw_codes):
    arch, params = networks
    z = draw_codes(200, np.random.default_rng(7)).astype(np.float32)[:, None]
    z[..., 6:] *= 100
    theta = np.linspace(0, np.pi / 2, 50, dtype=np.float32)
    wi = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)
    weights, alphas = sampler.mixture(params, arch, z, wi)
    assert weights.shape == (200, 50, 4) and alphas.shape == (200, 50, 3)
    np.testing.assert_allclose(weights.sum(axis=-1), 1, atol=1e-6)
    assert (weights >= 0).all() and (weights[..., -1] >= 0.0199).all()
    assert (alphas >= np.float32(0.01)).all() and (alphas <= 1).all()


def test_activations_match_their_definitions():
    x = np.linspace(-200, 200, 4001)
    np.testing.assert_array_equal(activate(x, "relu"), np.maximum(x, 0))
    within, step = np.clip(x, -2, 2), lambda t: t * t * (3 - 2 * t)  # Hermite's cubic
    np.testing.assert_allclose(
        activate(x, "smoothstep"), x * step((within + 2) / 4), rtol=1e-12, atol=1e-13
    )
    np.testing.assert_allclose(activate(x, "silu7"), x / (1 + np.exp(-x)), atol=0.02)
    outside = np.abs(x) > 6
    np.testing.assert_allclose(activate(x, "silu7")[outside], np.maximum(x, 0)[outside], atol=1e-11)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_slopes_are_the_activations_derivatives(activation):
    x, step = np.linspace(-9.95, 9.95, 200), 1e-6  # no kink within a step
    change = (activate(x + step, activation) - activate(x - step, activation)) / (2 * step)
    value, slope = with_slope(x, activation)
    np.testing.assert_allclose(slope, change, atol=1e-7)
    np.testing.assert_allclose(value, activate(x, activation), atol=1e-14)


def test_scaled_codes_scale_f_equally_for_all_pairs(networks, pairs):
    arch, params = networks
    z = np.random.default_rng(5).normal(size=(3, 1, 18)).astype(np.float32)
    features = direction_features(*pairs)
    factor = np.array([[0.25], [1.0], [3.0]], np.float32)
    f = decoder.decode(params, arch, z, features)
    scaled = decoder.decode(params, arch, decoder.scaled(z, factor), features)
    assert np.allclose(scaled, factor * f, rtol=1e-5)  # single precision of the exponent
    assert np.array_equal(scaled[1], f[1])


def test_values_and_derivatives_come_from_the_same_networks(networks, pairs):
    arch, params = networks
    own = UrushiNetworks(params, arch)
    rows = np.random.default_rng(9).uniform(0, 2, (3, arch.probes)).astype(np.float32)
    codes, slopes = own.encode_log(encoder.log_values(rows))
    whole = own.encode(rows, np.array(NO_LOBE, np.float32))
    np.testing.assert_allclose(codes, whole[:, 6:], atol=1e-4)
    logs, _ = own.decode_log(whole[:, None], direction_features(*pairs))
    np.testing.assert_allclose(np.exp(logs), own.f(whole[:, None], *pairs), rtol=1e-4)
    assert slopes.shape == (3, 18, arch.probes)
