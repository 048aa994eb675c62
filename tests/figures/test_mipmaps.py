"""The figure of mip levels: a small plane has the order of errors that the stored one has."""

import json

import mitsuba as mi
import numpy as np
import pytest
from figures.mipmaps import compute

from urushi.textures import cache, mip_pyramid


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_rgb")


def test_a_small_plane_agrees_with_the_stored_results(tmp_path):
    stored = json.loads((compute.FOLDER / "results.json").read_text())["plane"]
    found = compute.plane(width=80, height=48, side=4, folder=tmp_path)
    for errors in (stored, found):
        assert errors["Urushi"]["error"] < errors["no filter"]["error"]
        urushi, averaged = (np.mean(errors[name]["rows"]) for name in reversed(compute.METHODS[1:]))
        assert urushi < averaged
        # The average of codes is darker than the average of BRDFs.
        assert errors["averages of codes"]["light"] < -0.1 < errors["Urushi"]["light"] < 0.1
    # At the horizon a pixel covers whole patterns, and levels have less error than aliasing.
    near_horizon = {name: np.mean(stored[name]["rows"][:20]) for name in compute.METHODS}
    assert near_horizon["Urushi"] < 0.4 * near_horizon["no filter"]


def test_a_method_without_error_has_no_differences():
    reference = np.linspace(0.5, 1, 4 * 5 * 3).reshape(4, 5, 3)
    pictures = dict.fromkeys((*compute.METHODS, "reference"), reference)
    for part in compute.differences(pictures).values():
        assert part == {"error": 0, "light": 0, "rows": [0] * 4}


def test_codes_are_averaged_only_while_the_context_lasts(tmp_path, monkeypatch):
    """Textures of such levels are not kept for other processes, nor are theirs read."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    by_light, codes = (mip_pyramid.lifted, mip_pyramid.dropped), np.arange(3.0)
    with compute.codes_averaged():
        assert mip_pyramid.lifted(None, codes) is codes is mip_pyramid.dropped(None, codes)
        assert cache.folder() is None
    assert (mip_pyramid.lifted, mip_pyramid.dropped) == by_light
    assert cache.folder() == tmp_path
