"""Derivatives of layering and encoding, where the limit of energy acts and where it does not."""

import numpy as np
import pytest

from urushi.material import gradients
from urushi.material.encode import encoder_codes
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_texels
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model

ROWS = 24
NAMES = ("alpha", "eta", "albedo", "sigma_t", "g")


@pytest.fixture(scope="module")
def gaining(small) -> Model:
    """Networks with codes whose gain is too high: encoder and layerer gain energy."""
    params = dict(small.params)
    for part, gain in (("encoder", 1.1), ("layerer", 0.5)):
        last = f"{part}.{len(getattr(small.arch, part))}"
        params[f"{last}.weight"] = 0.3 * params[f"{last}.weight"]
        params[f"{last}.bias"] = params[f"{last}.bias"] + gain * (np.arange(18) == 0)
    return Model.of(small.arch, params, {})


@pytest.fixture(scope="module")
def inputs(gaining):
    """f (N, P) of diffuse surfaces under a lobe, codes of them, and coats."""
    rng = np.random.default_rng(0)
    pairs = gaining.networks.pairs()
    lobe = np.tile(np.array(lobes.NO_LOBE, np.float32), (ROWS, 1))
    lobe[:, :3] = rng.uniform([0.1, 0.1, 0.2], [0.6, 0.5, 0.9], (ROWS, 3))
    reflectance = np.linspace(0.05, 0.6, ROWS)[:, None]
    f = lobes.f(lobe[:, None], *pairs) + reflectance / np.pi
    f = (f * np.exp(0.02 * rng.normal(size=f.shape))).astype(np.float32)
    coat = rng.uniform([0.1, 1.2, 0.5, 0.1, -0.3], [0.6, 2, 0.9, 1, 0.5], (ROWS, 5))
    return f, limit_albedo(gaining, encoder_codes(gaining, f)), coat.astype(np.float32)


def layered(model, z, coat):
    return layer_texels(model, z, **dict(zip(NAMES, coat.T.astype(np.float64), strict=True)))


def test_the_limit_acts_on_some_codes_and_not_on_others(gaining, inputs):
    _, z, coat = inputs
    over = gradients._limited_coats(gaining, z, coat, layered(gaining, z, coat))
    assert 0 < len(over) < ROWS


def test_the_width_of_no_interface_has_no_derivative(gaining, inputs):
    _, z, coat = inputs
    coat = np.where(np.arange(5) == 1, np.float32(1), coat)
    code, one = layered(gaining, z, coat), np.eye(5)[[0]] * np.ones((ROWS, 1))
    np.testing.assert_array_equal(layered(gaining, z, coat * [0.5, 1, 1, 1, 1]), code)
    assert not gradients.layer_pushforward(gaining, z, coat, code, 0 * z, one).any()
    _, of_coat = gradients.layer_pullback(gaining, z, coat, code, np.ones_like(z))
    assert not of_coat[:, 0].any() and np.isfinite(of_coat).all() and of_coat[:, 3].any()


def test_layer_against_differences(gaining, inputs):
    """To 2 %: single precision, and the table of lobes' albedos is interpolated linearly.

    Another direction may become the one with the largest albedo within a step: rows may differ.
    """
    _, z, coat = inputs
    rng = np.random.default_rng(1)
    dz = rng.normal(size=z.shape).astype(np.float32)
    dz[:, :6] *= [0.1, 0.1, 0.1, 0, 0, 0]
    dcoat = rng.normal(size=coat.shape).astype(np.float32) * [0.1, 0.1, 0.1, 0.03, 0.1]
    step = 1e-3
    upper, lower = (
        layered(gaining, z + np.float32(way * step) * dz, coat + way * step * dcoat)
        for way in (1, -1)
    )
    expected = (upper - lower) / (2 * step)
    actual = gradients.layer_pushforward(gaining, z, coat, layered(gaining, z, coat), dz, dcoat)
    error = np.abs(actual - expected).max(axis=-1) / np.abs(expected).max(axis=-1)
    assert np.sort(error)[-4] < 2e-2


def test_the_limit_follows_the_lobe(gaining, inputs):
    """More reflection at the interface leaves less for the rest, whatever the network says."""
    _, z, coat = inputs
    coated = layered(gaining, z, coat)
    rows = gradients._limited_coats(gaining, z, coat, coated)
    for row in rows:
        of_z = gradients._log_factor(gaining, coated[row])
        assert of_z[4] < 0  # eta above one reflects more
        assert of_z[6] == pytest.approx(-1, abs=1e-4)  # the gain is given back


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
    forward = u * gradients.encode_pushforward(gaining, f, z, df)
    backward = (gradients.encode_pullback(gaining, f, z, u)[0] * df).sum(axis=-1)
    size = np.abs(forward).sum(axis=-1)
    np.testing.assert_allclose((forward.sum(axis=-1) - backward) / size, 0, atol=1e-4)
