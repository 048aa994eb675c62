"""Comparisons of pictures: closed forms and bounds."""

import numpy as np
import pytest
from benchmarks.pictures import BEST_PSNR, compare

from urushi.core.error_metrics import srgb

WHOLE = np.ones((24, 32), bool)


@pytest.fixture
def picture():
    return np.random.default_rng(1).random((24, 32, 3))


def test_equal_pictures_and_black_and_white(picture):
    assert compare(picture, picture, WHOLE) == (BEST_PSNR, 0)
    black = np.zeros((24, 32, 3))
    # The largest value of FLIP; its colour term alone is near one here (Andersson et al. 2020).
    assert compare(black + 1, black, WHOLE).flip == pytest.approx(1, abs=0.05)


def test_a_constant_difference_of_display_values():
    a, b = (np.full((24, 32, 3), v) for v in (0.2, 0.3))
    expected = -20 * np.log10(srgb(np.array(0.3)) - srgb(np.array(0.2)))
    assert compare(a, b, WHOLE).psnr == pytest.approx(expected, abs=0.01)


def test_pixels_outside_the_mask_do_not_count(picture):
    mask, other = WHOLE.copy(), picture.copy()
    mask[12:], other[12:] = False, 0.5
    assert compare(other, picture, mask).psnr == BEST_PSNR
