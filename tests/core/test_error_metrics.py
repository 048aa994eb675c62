"""E, P and the losses of fits against values computed by hand."""

import numpy as np
import pytest

from urushi.core import error_metrics
from urushi.errors import ParameterError


def test_stack_error_by_hand():
    # Weights 0.5 * 1, 1 * 1: (1 * 0.5 + 1 * 1) / (2 * 0.5 + 4 * 1) = 1.5 / 5.
    error = error_metrics.stack_error([3.0, 3.0], [2.0, 4.0], [0.5, 1.0], [1.0, 1.0])
    assert error == pytest.approx(0.3, rel=1e-12)


def test_stack_error_clamps_grazing_cosines():
    # Both cosines at 0.02 give the weight 4e-4 to the first pair, below the horizon or not.
    error = error_metrics.stack_error([2.0, 1.0], [1.0, 1.0], [1e-6, 1.0], [-1.0, 1.0])
    assert error == pytest.approx(4e-4 / (1 + 4e-4), rel=1e-12)


def test_stack_error_of_a_scaled_brdf_is_the_scale():
    rng = np.random.default_rng(1)
    f, cosines = rng.uniform(0.1, 9, (5, 40)), rng.uniform(0, 1, (2, 5, 40))
    np.testing.assert_allclose(error_metrics.stack_error(1.25 * f, f, *cosines), 0.25, rtol=1e-12)
    np.testing.assert_array_equal(error_metrics.stack_error(f, f, *cosines), np.zeros(5))


def test_pair_error_by_hand():
    np.testing.assert_allclose(
        error_metrics.pair_error([0.003, 2.0, 0.0], [0.001, 1.999, 0.0]),
        [1.0, 0.0005, 0.0],
        rtol=1e-9,
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: error_metrics.pair_error([1.0, 2.0], [1.0, 2.0, 3.0]),
            "shapes do not fit together",
        ),
        (lambda: error_metrics.pair_error([np.inf], [1.0]), "f_hat holds NaN"),
        (lambda: error_metrics.stack_error([0.0], [0.0], [1.0], [1.0]), "reflects no energy"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
