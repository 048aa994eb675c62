"""Measures of error against values computed by hand, and what a display shows of a picture."""

import numpy as np
import pytest
from benchmarks import measures

from urushi.core import error_metrics as metrics
from urushi.errors import ParameterError


def test_errors_of_brdfs_by_hand():
    # Weights 0.5 * 1, 1 * 1: (1 * 0.5 + 1 * 1) / (2 * 0.5 + 4 * 1) = 1.5 / 5.
    error = measures.stack_error([3.0, 3.0], [2.0, 4.0], [0.5, 1.0], [1.0, 1.0])
    assert error == pytest.approx(0.3, rel=1e-12)
    # Both cosines at 0.02 give the weight 4e-4 to the first pair, below the horizon or not.
    error = measures.stack_error([2.0, 1.0], [1.0, 1.0], [1e-6, 1.0], [-1.0, 1.0])
    assert error == pytest.approx(4e-4 / (1 + 4e-4), rel=1e-12)
    errors = measures.pair_error([0.003, 2.0, 0.0], [0.001, 1.999, 0.0])
    np.testing.assert_allclose(errors, [1.0, 0.0005, 0.0], rtol=1e-9)


def test_image_errors_by_hand():
    image, reference = np.array([[[1.0, 0.0]]]), np.array([[[0.5, 0.0]]])
    assert metrics.mse(image, reference) == pytest.approx(0.125)
    assert metrics.relative_mse(image, reference) == pytest.approx((0.25 / 0.26 + 0.0 / 0.01) / 2)
    subtracted = metrics.relative_mse(image, reference, variance=0.25)
    assert subtracted == pytest.approx((0.0 / 0.26 - 0.25 / 0.01) / 2)
    assert metrics.psnr(image, reference) == pytest.approx(10 * np.log10(1 / 0.125))
    assert metrics.psnr(image, image) == np.inf


def test_subtracted_noise_is_the_product_of_differences_to_both_halves():
    """(x - r)^2 - (a - b)^2 / 4 = (x - a)(x - b) with r = (a + b) / 2."""
    x, a, b = np.random.default_rng(3).uniform(0, 2, (3, 8, 8, 3))
    reference = (a + b) / 2
    direct = ((x - a) * (x - b) / (reference**2 + 0.01)).mean()
    ours = metrics.relative_mse(x, reference, variance=metrics.halves_variance(a, b))
    assert ours == pytest.approx(direct, rel=1e-10)


def test_srgb_is_that_of_the_norm_and_clipped():
    """The inverse of IEC 61966-2-1, within the norm's own gap."""
    display = np.linspace(0, 1, 101)
    linear = np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(metrics.srgb(linear), display, atol=1e-4)
    shown = metrics.shown(np.array([[[-1.0, 0.0, 7.0]]]))
    np.testing.assert_allclose(shown, [[[0, 0, 1]]], atol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: measures.pair_error([1.0, 2.0], [1.0, 2.0, 3.0]), "shapes do not fit together"),
        (lambda: measures.pair_error([np.inf], [1.0]), "f_hat holds NaN"),
        (lambda: measures.stack_error([0.0], [0.0], [1.0], [1.0]), "reflects no energy"),
        (lambda: metrics.mse([np.nan], [1.0]), "image holds NaN"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
