"""The figure of scenes: results are complete, and a small computation agrees with them."""

import json

import mitsuba as mi
import numpy as np
import pytest
from figures.results import shown_pictures
from figures.scenes import compute, plot


def test_the_results_have_all_scenes_and_networks_have_the_smaller_error_at_equal_time():
    found = json.loads((compute.FOLDER / "results.json").read_text())
    assert found["scenes"].keys() == compute.CASES.keys() == plot.INSETS.keys()
    for name, part in found["scenes"].items():
        counts = [part[method]["samples"] for method in compute.METHODS]
        assert counts[0] == (compute.COUNT if compute.CASES[name].equal_time else 1)
        assert part["networks"]["relative_mse"] < part["walk"]["relative_mse"]


def test_insets_lie_inside_the_pictures():
    for insets in plot.INSETS.values():
        for x, y in insets:
            assert 0 <= x <= compute.WIDTH - plot.SIDE
            assert 0 <= y <= compute.WIDTH * 3 // 4 - plot.SIDE


def test_one_sample_by_networks_has_less_noise_than_one_by_the_walk(tmp_path):
    pytest.importorskip("flip_evaluator", reason="FLIP needs the package flip-evaluator")
    mi.set_variant("llvm_ad_rgb")
    found = compute.part("shoe-point", width=64, samples=64, folder=tmp_path)
    # Pixels are large here, so that edges and relief are most of the noise of both.
    assert found["networks"]["relative_mse"] < found["walk"]["relative_mse"]
    assert found["networks"]["flip"] < found["walk"]["flip"]
    pictures = shown_pictures(tmp_path / "shoe-point.npz")
    assert {picture.shape for picture in pictures.values()} == {(48, 64, 3)}
    assert all(np.isfinite(picture).all() for picture in pictures.values())
