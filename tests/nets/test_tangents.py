"""Pushforwards agree with finite differences, and pullbacks with pushforwards."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import derivatives, encoder, layerer, lobe
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.lobe_fit_slopes import fit_slopes

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


def close_but_for_kinks(actual, function, step, tolerance):
    """Compare slopes with differences of a function of one number at zero.

    Where a ReLU's kink is within the step, both one-sided differences differ by far more than by
    the step times the second derivative, and there is no slope.
    """
    here = function(0.0)
    above, below = (function(step) - here) / step, (here - function(-step)) / step
    expected = 0.5 * (above + below)
    scale = np.abs(expected).max()
    smooth = np.abs(above - below) < 10 * tolerance * scale
    assert smooth.mean() > 0.99
    np.testing.assert_allclose(actual[smooth], expected[smooth], atol=tolerance * scale)


def layer_inputs(draw_codes, rng):
    """Codes of bottoms with all kinds of lobes, coats of any index, and changes of both."""
    z, coat = draw_codes(ROWS, rng), coats(rng)
    z[:, 5] += np.where(z[:, 5] > 0, 0.1, 0)  # k is one-sided at zero
    coat[:, 1] = rng.uniform(0.55, 2.9, ROWS)
    dz, dcoat = rng.normal(size=z.shape), rng.normal(size=(ROWS, 5))
    dz[:, 0] *= 1e-2
    dz[:, 5] *= z[:, 5] > 0
    dcoat[:, 3] *= coat[:, 3] > 0.01
    return z, coat, dz, dcoat


def test_layer_forward_against_differences(double, draw_codes, rng):
    params, arch = double
    z, coat, dz, dcoat = layer_inputs(draw_codes, rng)
    actual = derivatives.layer_pushforward(params, arch, z, coat, dz, dcoat)
    close_but_for_kinks(
        actual, lambda t: layered(params, arch, z + t * dz, coat + t * dcoat), 1e-7, 1e-5
    )
    np.testing.assert_array_equal(actual[:, [0, 4]], dcoat[:, :2])


def test_layer_backward_is_the_transpose_of_forward(double, draw_codes, rng):
    """<u, J v> = <J^T u, v> for any u and v, to rounding."""
    params, arch = double
    z, coat, dz, dcoat = layer_inputs(draw_codes, rng)
    u = rng.normal(size=z.shape)
    of_z, of_coat = derivatives.layer_pullback(params, arch, z, coat, u)
    forward = (u * derivatives.layer_pushforward(params, arch, z, coat, dz, dcoat)).sum(axis=-1)
    backward = (of_z * dz).sum(axis=-1) + (of_coat * dcoat).sum(axis=-1)
    np.testing.assert_allclose(forward, backward, rtol=1e-9, atol=1e-9)


def glossy(rng, count, alpha=(0.05, 0.6)):
    """Values (N, 192) of diffuse surfaces under one lobe, and what a share more of it adds.

    The change is that of ln alpha, of both factors and of the diffuse term, by random amounts.
    """
    width = rng.uniform(*alpha, count)[:, None]
    factors, diffuse = rng.uniform(0.05, 0.6, (2, count, 1)), rng.uniform(0.05, 0.5, (count, 1))
    rates = rng.normal(size=(4, count, 1))
    pairs = [w.astype(np.float64) for w in probe_pairs(192)]
    fifth = (1 - lobe.cosine_to_facet(*pairs)) ** 5

    def f(t):
        normal, grazing = (x * (1 + t * r) for x, r in zip(factors, rates[1:3], strict=True))
        shape = lobe.shape(width * np.exp(t * rates[0]), *pairs)
        lambert = diffuse * (1 + t * rates[3]) / np.pi
        return shape * (normal * (1 - fifth) + grazing * fifth) + lambert

    numbers = np.concatenate([width, *factors], axis=-1)
    rate = np.concatenate([width * rates[0], factors[0] * rates[1], factors[1] * rates[2]], axis=-1)
    return f(0.0), (f(1e-6) - f(-1e-6)) / 2e-6, numbers, rate


def test_fitted_lobes_follow_the_values(rng):
    """Of BRDFs that are one lobe over a diffuse surface, the fitted numbers are exact."""
    f, df, numbers, rate = glossy(rng, 30)
    lobes = np.tile(np.array(lobe.NO_LOBE), (30, 1))
    lobes[:, :3] = numbers
    found = (fit_slopes(f, lobes) @ df[..., None])[..., 0]
    np.testing.assert_allclose(found, rate, rtol=1e-3, atol=1e-3)


def test_slopes_of_fitted_lobes_against_fits(rng):
    """Of values with deviations of 3 %, for which no lobe is exact.

    The fit ends after some steps, and its function has kinks: medians agree, not every row.
    """
    f, df, _, _ = glossy(rng, 60)
    f = f * np.exp(0.03 * rng.normal(size=f.shape))
    step = 1e-2
    change = (fit_lobes(f + step * df) - fit_lobes(f - step * df))[:, :3] / (2 * step)
    found = (fit_slopes(f, fit_lobes(f)) @ df[..., None])[..., 0]
    error = np.abs(found - change) / (np.abs(change) + 0.02)
    assert (np.median(error, axis=0) < 0.05).all()
    assert (np.quantile(error, 0.8, axis=0) < 0.3).all()


def test_surfaces_without_a_lobe_have_finite_slopes(rng):
    f = np.stack([np.zeros(192), np.full(192, 0.1), rng.random(192)])
    assert np.isfinite(fit_slopes(f, fit_lobes(f))).all()


def test_white_media_and_black_brdfs_have_finite_derivatives(double, draw_codes, rng):
    params, arch = double
    coat = coats(rng)
    coat[:, 2] = 1.0
    of_z, of_coat = derivatives.layer_pullback(
        params, arch, draw_codes(ROWS, rng), coat, rng.normal(size=(ROWS, 24))
    )
    assert np.isfinite(of_z).all()
    assert np.isfinite(of_coat).all()
    black = np.zeros((1, 192))
    gradient = derivatives.encode_pullback(params, arch, black, np.ones((1, 18)))
    assert np.isfinite(gradient).all()
    assert gradient.any()


def test_encoder_against_differences(double, rng):
    """A lobe whose fit is exact over a coloured rest; the encoder sees the rest alone."""
    params, arch = double
    f, df, numbers, rate = glossy(rng, 20)
    lobes = np.tile(np.array(lobe.NO_LOBE), (20, 1))
    lobes[:, :3] = numbers
    pairs = probe_pairs(192)

    def codes(t):
        moved = np.array(lobes)
        moved[:, :3] += t * rate
        rest = f + t * df - lobe.f(moved[:, None], *pairs)
        return np.concatenate([moved, encoder.encode(params, arch, rest)], axis=-1)

    rest = f - lobe.f(lobes[:, None], *pairs)
    dlobe = derivatives.lobe_pushforward(arch, f, df, lobes)
    slopes = derivatives.top_slopes(arch, lobes)
    drest = df - (slopes * dlobe[..., None]).sum(axis=1)
    dz = derivatives.encode_pushforward(params, arch, rest, drest)
    actual = np.concatenate([dlobe, dz], axis=-1)
    close_but_for_kinks(actual, codes, 1e-6, 5e-3)
    u = rng.normal(size=actual.shape)
    of_rest = derivatives.encode_pullback(params, arch, rest, u[:, 6:])
    of_lobe = u[:, :6] - (slopes @ of_rest[..., None])[..., 0]
    of_f = of_rest + derivatives.lobe_pullback(arch, f, of_lobe, lobes)
    backward = (of_f * df).sum(axis=-1)
    np.testing.assert_allclose((u * actual).sum(axis=-1), backward, rtol=1e-7, atol=1e-7)
