"""Figure 7: docs and results agree, and a small new computation agrees with both."""

import json

import mitsuba as mi
import pytest
from figures.figure_7 import compute


@pytest.fixture(scope="module")
def found():
    return json.loads((compute.FOLDER / "results.json").read_text())


def test_all_materials_are_there_and_networks_have_the_least_error(found):
    assert set(found["materials"]) == set(compute.materials())
    for methods in found["materials"].values():
        others = (methods["walk"]["error"], methods["Belcour 2018"]["error"])
        assert methods["networks"]["error"] < min(others)
        assert methods["networks"]["samples"] == compute.SAMPLES
        assert abs(methods["networks"]["bias"]) < 0.1 * methods["Belcour 2018"]["bias"] + 1e-4


def test_a_small_computation_finds_the_same_biases(found, tmp_path, monkeypatch):
    mi.set_variant("llvm_ad_rgb")
    monkeypatch.setattr(compute, "PARTS", tmp_path)
    name = "gold,\nscattering coat"
    stored = found["materials"][name]
    times = {method: stored[method]["time"] for method in compute.PLUGINS}
    (tmp_path / "errors").mkdir()
    again = compute.errors(
        name, compute.materials()[name], times, size=24, reference=512, endless=256, renders=2
    )
    # A seventh of the pixels along a side: edges have a larger share.
    bias = again["Belcour 2018"]["bias"]
    assert bias == pytest.approx(stored["Belcour 2018"]["bias"], rel=0.3)
    assert abs(again["networks"]["bias"]) < 0.05 * bias
    assert compute.picture_file(name).is_file()
