"""Derivatives of layering and encoding, where the limit of energy acts and where it does not."""

import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.material import gradients
from urushi.material.encode import encoder_codes, limited_codes
from urushi.material.layer import layer_texels
from urushi.nets.weights import Model
from urushi.paper.architecture import PaperArchitecture
from urushi.paper.architecture import init as init_paper

ROWS = 24
NAMES = ("alpha", "eta", "albedo", "sigma_t", "g")
#: Every second coat is nearly clear; over a bright bottom the limit scales its code down.
CLEAR, CLOUDY = [0.2, 1.3, 0.9, 0.02, 0.0], [0.3, 1.5, 0.7, 1.0, 0.3]


@pytest.fixture(scope="module")
def gaining(trained) -> Model:
    """The shipped networks with codes whose gain is too high: encoder and layerer gain energy."""
    params = dict(trained.params)
    for part, gain in (("encoder", 0.2), ("layerer", 0.7)):
        last = f"{part}.{len(getattr(trained.arch, part))}.bias"
        params[last] = params[last] + gain * (np.arange(trained.arch.latent) == 0)
    return Model.of(trained.arch, params, {})


@pytest.fixture(scope="module")
def inputs(gaining):
    """f (N, P) of Lambertian BRDFs, codes of them and of ones that gain energy, and coats."""
    rng = np.random.default_rng(0)
    reflectance = np.linspace(0.1, 0.99, ROWS)[:, None]
    f = np.broadcast_to(reflectance / np.pi, (ROWS, len(gaining.networks.pairs()[0])))
    f = (f * np.exp(0.05 * rng.normal(size=f.shape))).astype(np.float32)
    z = limited_codes(gaining, f)
    z[-5:, 0] += 0.2  # albedos above one
    coat = np.where(np.arange(ROWS)[:, None] % 2, CLEAR, CLOUDY).astype(np.float32)
    return f, z, coat


def layered(model, z, coat):
    return layer_texels(model, z, **dict(zip(NAMES, coat.T.astype(np.float64), strict=True)))


def differences(function, step):
    """A central difference: `function` of plus and of minus the step, over twice of it."""
    return (function(step) - function(-step)) / (2 * step)


def test_the_limit_acts_on_some_codes_and_not_on_others(gaining, inputs):
    """Lest the tests below compare nothing."""
    f, z, coat = inputs
    unlimited = gradients._unlimited(gaining, z, coat)
    over = gradients._limited_rows(gaining, layered(gaining, z, coat), unlimited)
    assert 0 < len(over) < ROWS
    over = gradients._limited_rows(gaining, limited_codes(gaining, f), encoder_codes(gaining, f))
    assert 0 < len(over) < ROWS


def test_layer_against_differences(gaining, inputs):
    """To 0.5 %: single precision of codes, and a step of 1e-3, leave a tenth of that.

    The largest albedo is found among 41 directions. Within a step another direction may become the
    largest, and the derivative jumps there: two rows may differ.
    """
    _, z, coat = inputs
    rng = np.random.default_rng(1)
    dz = rng.normal(size=z.shape).astype(np.float32)
    dcoat = rng.normal(size=coat.shape).astype(np.float32) * [0.1, 0.1, 0.1, 0.01, 0.1]
    expected = differences(
        lambda step: layered(gaining, z + np.float32(step) * dz, coat + step * dcoat), 1e-3
    )
    actual = gradients.layer_pushforward(gaining, z, coat, layered(gaining, z, coat), dz, dcoat)
    error = np.abs(actual - expected).max(axis=-1) / np.abs(expected).max(axis=-1)
    assert np.sort(error)[-3] < 5e-3


def test_encode_against_differences(gaining, inputs):
    """As above."""
    f, _, _ = inputs
    df = f * np.random.default_rng(1).normal(size=f.shape).astype(np.float32)
    expected = differences(lambda step: limited_codes(gaining, f + np.float32(step) * df), 2e-3)
    actual = gradients.encode_pushforward(gaining, f, limited_codes(gaining, f), df)
    error = np.abs(actual - expected).max(axis=-1) / np.abs(expected).max(axis=-1)
    assert np.sort(error)[-3] < 5e-3


def test_backward_is_the_transpose_of_forward(gaining, inputs):
    """<u, J v> = <J^T u, v>, to single precision."""
    f, z, coat = inputs
    rng = np.random.default_rng(2)
    u, dz = rng.normal(size=(2, *z.shape)).astype(np.float32)
    dcoat = rng.normal(size=coat.shape).astype(np.float32)
    coated = layered(gaining, z, coat)
    forward = u * gradients.layer_pushforward(gaining, z, coat, coated, dz, dcoat)
    of_z, of_coat = gradients.layer_pullback(gaining, z, coat, coated, u)
    backward = (of_z * dz).sum(axis=-1) + (of_coat * dcoat).sum(axis=-1)
    size = np.abs(forward).sum(axis=-1)
    np.testing.assert_allclose((forward.sum(axis=-1) - backward) / size, 0, atol=1e-4)

    df = f * rng.normal(size=f.shape).astype(np.float32)
    codes = limited_codes(gaining, f)
    forward = u * gradients.encode_pushforward(gaining, f, codes, df)
    backward = (gradients.encode_pullback(gaining, f, codes, u) * df).sum(axis=-1)
    size = np.abs(forward).sum(axis=-1)
    np.testing.assert_allclose((forward.sum(axis=-1) - backward) / size, 0, atol=1e-4)


def test_the_papers_networks_are_refused():
    model = Model.of(PaperArchitecture(), init_paper(0), {})
    with pytest.raises(
        ParameterError, match="the coat: gradients are asked for.*'base' or 'small'"
    ):
        gradients.check_differentiable(model, "the coat")
