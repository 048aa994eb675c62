"""Averages and comparisons of what textures of the paper's codes are made of."""

import numpy as np
import pytest


@pytest.mark.parametrize(("width", "height"), [(8, 4), (7, 5), (5, 1), (1, 6)])
def test_every_level_keeps_the_average(rgb, width, height):
    from urushi.fan2022.texels import half_resolution

    values = np.random.default_rng(1).random((height, width, 2)).astype(np.float32)
    mean = values.mean(axis=(0, 1))
    while values.shape != (1, 1, 2):
        sides = [max(side // 2, 1) for side in values.shape[:2]]
        values = half_resolution(values)
        assert values.shape == (*sides, 2)
        np.testing.assert_allclose(values.mean(axis=(0, 1)), mean, rtol=1e-5)


def test_rows_are_the_same_within_rounding(rgb):
    from urushi.fan2022.texels import different_rows

    f = np.random.default_rng(2).random((5, 40)).astype(np.float32) + 0.1
    f[0, 0] = 0
    rows = f[[3, 0, 3, 1, 4, 0, 2]]
    first, place = different_rows(rows)
    assert len(first) == 5
    np.testing.assert_array_equal(rows[first][place], rows)
