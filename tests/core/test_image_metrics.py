"""Measures of pictures: closed forms and bounds."""

import numpy as np
import pytest
from benchmarks.pictures import BEST_PSNR, compare

from urushi.core.error_metrics import shown, srgb

WHOLE = np.ones((24, 32), bool)


def linear(display):
    """The inverse of `srgb`, as IEC 61966-2-1 states it."""
    return np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)


@pytest.fixture
def picture():
    return np.random.default_rng(1).random((24, 32, 3))


def test_srgb_and_its_inverse():
    display = np.linspace(0, 1, 101)
    np.testing.assert_allclose(srgb(linear(display)), display, atol=1e-4)  # the norm's own gap


def test_shown_clips_values_outside_the_display_range():
    np.testing.assert_allclose(shown(np.array([[[-1.0, 0.0, 7.0]]])), [[[0, 0, 1]]], atol=1e-12)


def test_equal_pictures_and_black_and_white(picture):
    assert compare(picture, picture, WHOLE) == (BEST_PSNR, 0)
    black = np.zeros((24, 32, 3))
    # The largest value of FLIP; its colour term alone is near one here (Andersson et al. 2020).
    assert compare(black + 1, black, WHOLE).flip == pytest.approx(1, abs=0.05)


def test_a_constant_difference_of_display_values():
    a, b = (np.full((24, 32, 3), linear(np.array(v))) for v in (0.5, 0.6))
    assert compare(a, b, WHOLE).psnr == pytest.approx(20, abs=0.01)


def test_pixels_outside_the_mask_do_not_count(picture):
    mask, other = WHOLE.copy(), picture.copy()
    mask[12:], other[12:] = False, 0.5
    assert compare(other, picture, mask).psnr == BEST_PSNR
