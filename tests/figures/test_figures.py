"""Figures: parts are kept and continued, intervals cover, and stored results can be drawn."""

import json

import mitsuba as mi
import numpy as np
import pytest
from figures import results
from figures.figure_6 import compute as spheres
from figures.figure_8 import compute, plot
from figures.table_1 import compute as representations
from figures.table_1 import materials
from figures.table_1 import plot as representations_plot
from figures.table_3 import compute as scenes
from figures.table_3 import plot as scenes_plot

from urushi.core.direction_sets import cosine_pairs
from urushi.nets.weights import default_model


def test_finished_parts_are_read_and_not_computed_again(tmp_path):
    calls = []

    def part(name, fail=False):
        calls.append(name)
        if fail:
            raise RuntimeError("stopped")
        return {"name": name}

    parts = {"first": lambda: part("first"), "second": lambda: part("second", fail=True)}
    with pytest.raises(RuntimeError):
        results.collect(tmp_path, parts)
    parts["second"] = lambda: part("second")
    found = results.collect(tmp_path, parts)
    assert calls == ["first", "second", "second"]
    assert found == {"first": {"name": "first"}, "second": {"name": "second"}}


def test_the_interval_covers_the_mean_as_often_as_it_says():
    # 400 samples of 40 normal numbers: the share has a standard error of 1.1 %, and the percentile
    # method is short by about 1 % at this size.
    rng = np.random.default_rng(3)
    draws = rng.normal(size=(400, 40))
    inside = [low <= 0 <= high for low, high in map(results.interval, draws)]
    assert results.COVERAGE - 0.045 < np.mean(inside) < results.COVERAGE + 0.033


def test_rounded_keeps_shape_and_digits():
    values = np.array([[1.23456, 0.000123456], [123456, 0]])
    np.testing.assert_allclose(results.rounded(values, 3), values, rtol=5e-3)
    assert np.shape(results.rounded(values)) == values.shape


def test_the_stored_results_are_complete(stored_results):
    found = stored_results(compute, weights=default_model())
    for n in compute.INTERFACES:
        for name in plot.METHODS:
            values = np.array(found[f"interfaces_{n}"][name])
            assert values.shape == (compute.STACKS,) and (values > 0).all()
        assert max(found[f"interfaces_{n}"]["reference"]) < 0.004
    lobes = found["lobes"]
    assert np.shape(lobes["walk"]) == (len(compute.INTERFACES), len(compute.OUTGOING))


def test_networks_stay_near_the_walk_for_a_new_computation():
    lobes = compute.lobes(walks=1 << 10)
    walk, se, networks = (np.array(lobes[name]) for name in ("walk", "se", "networks"))
    # The mean of 430 values: noise of the walk, and 3 % for the codes.
    error = np.abs(networks - walk).sum() / walk.sum()
    assert error < 0.03 + se.sum() / walk.sum()


def test_the_grids_of_spheres_are_complete():
    found = json.loads((spheres.FOLDER / "results.json").read_text())
    for name, rows in spheres.materials().items():
        values = np.array(found[name])
        assert values.shape == (len(rows), len(rows[0]), 2) and (values > 0).all()


def test_a_material_of_the_grids_has_the_stored_error():
    found = json.loads((spheres.FOLDER / "results.json").read_text())
    coat, bottom = spheres.materials()["media"][3][2]
    e, own = spheres.error(coat, bottom, walks=1 << 11)
    # Noise adds to the mean of absolute differences at most what the walk's own error is.
    stored = found["media"][3][2][0]
    assert stored - 1e-3 < e < stored + own


def test_scenes_are_compared_at_equal_time_and_samples_add_up(tmp_path, monkeypatch):
    stored = json.loads((scenes.FOLDER / "results.json").read_text())["scenes"]
    for name, scene in stored.items():
        assert scene["walk"]["spp"] == scenes.SAMPLES[name]
        # Samples are whole: one of the teapot's is a fifteenth of a picture.
        assert abs(scene["networks"]["seconds"] / scene["walk"]["seconds"] - 1) < 0.1
        for method in scenes.METHODS:
            assert len(scene[method]["mse"]) == scenes.PICTURES
        ratio, low, high = scenes_plot.ratio_interval(scene)
        assert low < ratio < high
    # A small picture of few samples has the error of the stored ones, up to its size and noise.
    mi.set_variant("llvm_ad_rgb")
    monkeypatch.setattr(scenes, "PARTS", tmp_path)
    again = scenes.part("teapot", width=48, reference=256, pictures=2)
    assert 0.3 < np.mean(again["walk"]["mse"]) / np.mean(stored["teapot"]["walk"]["mse"]) < 3


def test_coloured_stacks_share_widths_and_indices_and_values_are_kept():
    table = materials.coloured(materials.Table2(1), np.random.default_rng(1), 4)
    for shared in (table.alpha, table.eta, table.bottom["alpha"]):
        assert (np.ptp(shared.reshape(4, 3), axis=1) == 0).all()
    assert (np.ptp(table.bottom["r0"].reshape(4, 3), axis=1) > 0).all()
    stack = materials.Walked(materials.rows(table, slice(3)), seed=1)
    wi, wo = cosine_pairs(np.random.default_rng(2), 4096)
    assert stack.f(wi, wo) is stack.f(wi, wo)
    other, se = stack.simulated(wi, wo, walks=64, seed=9)
    # 256 and 64 walks of other seeds: means of 4096 differences, with the noise of both.
    spread = np.sqrt(1.25 * (se**2).sum(axis=0)) / len(wi)
    assert (np.abs((stack.f(wi, wo) - other).mean(axis=0)) < 5 * spread).all()


def test_a_bare_conductor_is_represented_as_stored(stored_results):
    stored = stored_results(representations, weights=default_model())["materials"]
    subject = next(s for s in materials.subjects() if s.name == "conductor_0")
    rng = np.random.default_rng((materials.SEED, 1))
    pairs = cosine_pairs(rng, representations.REFERENCE["E"][0], lowest_cosine=0.02)
    model = representations.represent("Urushi, encoded", subject.source)
    e = representations.errors("E", model.f(*pairs), subject.source.f(*pairs), *pairs)
    # Fits on other processors end at slightly other codes.
    assert e == pytest.approx(stored["conductor_0"]["Urushi, encoded"]["E"], rel=0.5, abs=1e-4)


def test_some_methods_are_measured_and_the_others_kept():
    stored = json.loads((representations.FOLDER / "results.json").read_text())
    new = {"reference": 0.0, "BSDFNet": {"E": 1.0, "P": 1.0, "L1": 1.0, "seconds": 1.0}}
    found = {"evaluation": {"BSDFNet": 9.0}, "conductor_0": new}
    merged = representations.merged(stored, found)
    assert merged["materials"]["conductor_0"]["BSDFNet"] == new["BSDFNet"]
    assert merged["evaluation"]["BSDFNet"] == 9 and merged["groups"] == stored["groups"]
    for name, one in merged["materials"].items():
        assert one.keys() == stored["materials"][name].keys()
        kept = [m for m in one if name != "conductor_0" or m not in new]
        assert all(one[m] == stored["materials"][name][m] for m in kept)


def test_methods_without_results_are_left_out():
    found = json.loads((representations.FOLDER / "results.json").read_text())
    assert set(representations.METHODS) <= set(representations_plot.measured(found))
    del found["materials"]["stack_3"]["BSDFNet"]
    assert "BSDFNet" not in "\n".join(representations_plot.tables(found))


def test_storage_is_that_of_the_papers_discussion():
    storage = representations_plot.storage()
    assert storage["BSDFNet"][:2] == (3 * 293, 13_468)
    assert storage["NBRDF"][0] == 675 and storage["Fan 2022"][0] == 32 * 3
    assert storage["Fan 2022"][1] == pytest.approx(1e6, rel=0.1)
