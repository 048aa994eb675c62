"""Pushforwards agree with finite differences, and pullbacks with pushforwards."""

import numpy as np
import pytest

from urushi.nets import derivatives, encoder, layerer

ROWS = 40


@pytest.fixture(scope="module")
def double(networks):
    """The same networks in double precision, for finite differences."""
    arch, params = networks
    return {name: value.astype(np.float64) for name, value in params.items()}, arch


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def coats(rng) -> np.ndarray:
    """Coats (N, 5): alpha, eta, albedo, sigma_t, g; a few with a thin medium or little effect."""
    low, high = [0.01, 1.02, 0.0, 0.0, -0.9], [1.0, 2.5, 0.999, 8.0, 0.9]
    coat = rng.uniform(low, high, size=(ROWS, 5))
    coat[:8, 3] = rng.uniform(0, 0.01, size=8)
    coat[4:8, 0] = rng.uniform(0.01, 0.02, size=4)
    return coat


def layered(params, arch, z, coat):
    return layerer.layer(params, arch, z, tuple(coat.T))


def close_but_for_kinks(actual, expected):
    """Differences across a ReLU's kink are wrong; 1e-6 is far above their rounding error."""
    scale = np.abs(expected).max()
    assert np.mean(np.abs(actual - expected) > 1e-6 * scale) < 0.01


def test_layer_forward_against_differences(double, rng):
    params, arch = double
    z, coat = rng.normal(size=(ROWS, 32)), coats(rng)
    dz, dcoat = rng.normal(size=(ROWS, 32)), rng.normal(size=(ROWS, 5))
    step = 1e-7
    # one-sided, into the range: a coat may lie on its edge; error of a step of 1e-7 below 1e-6
    change = layered(params, arch, z + step * dz, coat + step * dcoat * [1, 1, 1, 0, 1])
    change += layered(params, arch, z, coat + step * np.abs(dcoat) * [0, 0, 0, 1, 0])
    expected = (change - 2 * layered(params, arch, z, coat)) / step
    dcoat[:, 3] = np.abs(dcoat[:, 3])
    actual = derivatives.layer_pushforward(params, arch, z, coat, dz, dcoat)
    scale = np.abs(expected).max()
    assert np.mean(np.abs(actual - expected) > 1e-5 * scale) < 0.01


def test_encode_forward_against_differences(double, rng):
    params, arch = double
    f = np.exp(rng.uniform(-6, 4, size=(ROWS, 192)))
    df = f * rng.normal(size=f.shape)
    step = 1e-6
    upper, lower = (encoder.encode(params, arch, f + sign * step * df) for sign in (1, -1))
    close_but_for_kinks(
        derivatives.encode_pushforward(params, arch, f, df), (upper - lower) / (2 * step)
    )


def test_backward_is_the_transpose_of_forward(double, rng):
    """<u, J v> = <J^T u, v> for any u and v, to rounding."""
    params, arch = double
    z, coat, u = rng.normal(size=(ROWS, 32)), coats(rng), rng.normal(size=(ROWS, 32))
    dz, dcoat = rng.normal(size=(ROWS, 32)), rng.normal(size=(ROWS, 5))
    of_z, of_coat = derivatives.layer_pullback(params, arch, z, coat, u)
    forward = (u * derivatives.layer_pushforward(params, arch, z, coat, dz, dcoat)).sum(axis=-1)
    backward = (of_z * dz).sum(axis=-1) + (of_coat * dcoat).sum(axis=-1)
    np.testing.assert_allclose(forward, backward, rtol=1e-9, atol=1e-9)

    f = np.exp(rng.uniform(-6, 4, size=(ROWS, 192)))
    df = f * rng.normal(size=f.shape)
    forward = (u * derivatives.encode_pushforward(params, arch, f, df)).sum(axis=-1)
    backward = (derivatives.encode_pullback(params, arch, f, u) * df).sum(axis=-1)
    np.testing.assert_allclose(forward, backward, rtol=1e-9, atol=1e-9)


def test_white_media_and_black_brdfs_have_finite_derivatives(double, rng):
    params, arch = double
    coat = coats(rng)
    coat[:, 2] = 1.0
    of_z, of_coat = derivatives.layer_pullback(
        params, arch, rng.normal(size=(ROWS, 32)), coat, rng.normal(size=(ROWS, 32))
    )
    assert np.isfinite(of_z).all()
    assert np.isfinite(of_coat).all()
    gradient = derivatives.encode_pullback(params, arch, np.zeros((1, 192)), np.ones((1, 32)))
    assert np.isfinite(gradient).all()
    assert gradient.any()
