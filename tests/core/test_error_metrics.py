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


def test_error_divisors_by_hand():
    # The mean of f, clipped to 1, is 1/2: a brightness of pi/2, at most 1. The floor is whole.
    np.testing.assert_allclose(
        error_metrics.error_divisors(np.array([[0.0, 7.0]])), [[0.002, 7.002]], rtol=1e-12
    )
    # Black: the floor is scaled by the least brightness.
    np.testing.assert_allclose(error_metrics.error_divisors(np.zeros(3)), np.full(3, 1e-4))


def test_huber_loss_by_hand_and_its_slope():
    error = np.array([-5.0, -2.0, -1.0, 0.0, 0.5, 3.0])
    loss, far = error_metrics.huber_loss(error, 2.0)
    np.testing.assert_allclose(loss, [16.0, 4.0, 1.0, 0.0, 0.25, 8.0], rtol=1e-12)
    step = 1e-6
    slope = (
        error_metrics.huber_loss(error + step, 2.0)[0]
        - error_metrics.huber_loss(error - step, 2.0)[0]
    ) / (2 * step)
    np.testing.assert_allclose(slope, 2 * error / far, rtol=1e-6, atol=1e-6)


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
