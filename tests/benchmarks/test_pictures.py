"""Comparisons of pictures: closed forms and bounds."""

import numpy as np
import pytest
from benchmarks.pictures import BEST_PSNR, compare

from urushi.core.error_metrics import srgb


def test_comparisons_are_of_display_values_inside_the_mask():
    whole = np.ones((24, 32), bool)
    a, b = (np.full((24, 32, 3), v) for v in (0.2, 0.3))
    expected = -20 * np.log10(srgb(np.array(0.3)) - srgb(np.array(0.2)))
    assert compare(a, b, whole).psnr == pytest.approx(expected, abs=0.01)
    mask, other = whole.copy(), a.copy()
    mask[12:], other[12:] = False, 0.5
    assert compare(other, a, mask).psnr == BEST_PSNR
    assert compare(a, a, whole) == (BEST_PSNR, 0)
    # The largest value of FLIP; its colour term alone is near one here (Andersson et al. 2020).
    assert compare(0 * a + 1, 0 * a, whole).flip == pytest.approx(1, abs=0.05)
