"""The measures of error against values computed by hand."""

import numpy as np
import pytest
from benchmarks.evaluation.report import summary

from urushi.core import error_metrics as metrics
from urushi.errors import ParameterError


def test_summary_of_one_to_hundred():
    assert summary(np.arange(101.0)) == pytest.approx({"mean": 50, "median": 50, "p95": 95})


def test_image_errors_by_hand():
    image, reference = np.array([[[1.0, 0.0]]]), np.array([[[0.5, 0.0]]])
    assert metrics.mse(image, reference) == pytest.approx(0.125)
    assert metrics.relative_mse(image, reference, offset=0.25) == pytest.approx(0.25)
    assert metrics.relative_mse(image, reference, variance=0.25, offset=0.25) == pytest.approx(
        (0.0 / 0.5 - 0.25 / 0.25) / 2
    )
    assert metrics.psnr(image, reference, peak=2.0) == pytest.approx(10 * np.log10(4 / 0.125))
    assert metrics.psnr(image, image) == np.inf


def test_noise_alone_leaves_no_relative_error():
    """An exact image against a noisy reference: nothing but the statistics' own spread is left.

    Relative noise variance 0.01 at value 1; its estimate has one degree of freedom, so the mean
    over n pixels spreads by 0.01 * sqrt(2 + 2) / sqrt(n) = 1e-4 at most; four times is allowed.
    """
    rng = np.random.default_rng(2)
    first, second = 1 + rng.normal(0, np.sqrt(0.02), (2, 200, 200, 1))
    reference, variance = (first + second) / 2, metrics.halves_variance(first, second)
    assert variance.mean() == pytest.approx(0.01, rel=0.05)
    exact, noise = np.ones_like(reference), 1e-2
    # A large offset keeps the denominator free of the noise under test.
    scaled = 1e3 * metrics.relative_mse(exact, reference, variance=variance, offset=1e3)
    assert abs(scaled) < 4e-4 < noise


def test_subtracted_noise_is_the_product_of_differences_to_both_halves():
    """(x - r)^2 - (a - b)^2 / 4 = (x - a)(x - b) with r = (a + b) / 2."""
    x, a, b = np.random.default_rng(3).uniform(0, 2, (3, 8, 8, 3))
    reference = (a + b) / 2
    direct = ((x - a) * (x - b) / (reference**2 + 0.1)).mean()
    ours = metrics.relative_mse(x, reference, variance=metrics.halves_variance(a, b), offset=0.1)
    assert ours == pytest.approx(direct, rel=1e-10)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: metrics.mse([np.nan], [1.0]), "image holds NaN"),
        (lambda: metrics.mse([1.0, 2.0], [1.0, 2.0, 3.0]), "shapes do not fit together"),
        (lambda: summary([]), "errors is empty"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
