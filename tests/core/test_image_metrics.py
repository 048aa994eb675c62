"""Measures of pictures: closed forms, bounds, and bad input."""

import sys
from importlib.util import find_spec

import numpy as np
import pytest
from benchmarks.quality.pictures import BEST_PSNR, Comparison, compare, ssim_map

from urushi.core.error_metrics import shown, srgb
from urushi.errors import ParameterError, PlatformError

#: flip-evaluator has no wheels for some platforms.
FLIP = find_spec("flip_evaluator") is not None


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


def test_equal_pictures(picture):
    found = compare(picture, picture, flip=False).as_dict()
    assert found.pop("flip") is np.nan
    assert found == {"mae": 0, "rmse": 0, "psnr": BEST_PSNR, "ssim": 1}


@pytest.mark.skipif(not FLIP, reason="flip-evaluator is not installed")
def test_flip_of_equal_pictures_and_of_black_and_white(picture):
    assert compare(picture, picture).flip == 0
    black = np.zeros((32, 32, 3))
    # The largest value of FLIP; its colour term alone is near one here (Andersson et al. 2020).
    assert compare(black + 1, black).flip == pytest.approx(1, abs=0.05)


def test_a_constant_difference_of_display_values():
    a, b = (np.full((16, 16, 3), linear(np.array(v))) for v in (0.5, 0.6))
    found = compare(a, b, flip=False)
    assert found.mae == pytest.approx(0.1, abs=1e-4)
    assert found.rmse == pytest.approx(0.1, abs=1e-4)
    assert found.psnr == pytest.approx(20, abs=0.01)
    # Without any structure only the luminance's term of Wang et al. 2004 is left, K1 = 0.01.
    assert found.ssim == pytest.approx((2 * 0.5 * 0.6 + 1e-4) / (0.25 + 0.36 + 1e-4), abs=1e-4)
    assert np.isnan(found.flip)


def test_exchanging_pictures_changes_nothing(picture):
    other = np.clip(picture + 0.1 * np.random.default_rng(2).normal(size=picture.shape), 0, 1)
    one, two = (compare(*p, flip=False).as_dict() for p in ((picture, other), (other, picture)))
    for name in ("mae", "rmse", "psnr", "ssim"):
        assert one[name] == pytest.approx(two[name], rel=1e-9)


def test_more_noise_is_worse_by_every_measure(picture):
    noise = np.random.default_rng(3).normal(size=picture.shape)
    little, much = (
        compare(picture + amount * noise, picture, flip=FLIP) for amount in (0.01, 0.05)
    )
    for name in ("mae", "rmse", "flip") if FLIP else ("mae", "rmse"):
        assert 0 < getattr(little, name) < getattr(much, name) < 1
    assert little.psnr > much.psnr
    assert 1 > little.ssim > much.ssim


def test_pixels_outside_the_mask_do_not_count(picture):
    mask = np.zeros(picture.shape[:2], bool)
    mask[:12] = True
    other = picture.copy()
    other[~mask] = 0.5
    found = compare(other, picture, mask, flip=False)
    assert (found.mae, found.psnr) == (0, BEST_PSNR)


def test_means_over_pictures():
    mean = Comparison.mean([Comparison(0, 1, 2, 3, 4), Comparison(2, 3, 4, 5, 6)])
    assert mean == Comparison(1, 2, 3, 4, 5)


def test_shapes_that_do_not_fit(picture):
    with pytest.raises(ParameterError, match=r"the pictures have shapes \(24, 32, 3\) and \(24, 3"):
        compare(picture, picture[:, :31])
    with pytest.raises(ParameterError, match="give one of the image's shape that is not empty"):
        compare(picture, picture, np.zeros((24, 32), bool))
    with pytest.raises(ParameterError, match="SSIM needs 11 in each direction"):
        compare(picture[:8], picture[:8])
    with pytest.raises(ParameterError, match="NaN or infinity"):
        compare(picture * np.nan, picture)


@pytest.mark.parametrize("package", ["skimage.metrics", "flip_evaluator"])
def test_missing_packages_are_named(picture, package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(PlatformError, match="needs the package .*; install it.*: pip install"):
        compare(picture, picture)


def test_similarity_by_pixel_shows_the_place_of_a_difference(picture):
    other = picture.copy()
    other[:, 26:] = 0.5
    similar = ssim_map(other, picture)
    np.testing.assert_allclose(similar[:, :20], 1, atol=1e-9)  # the window reaches 5 pixels
    assert (similar[:, 27:] < 0.9).all()
