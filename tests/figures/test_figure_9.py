"""Figure 9: docs and results agree, errors can be computed anew, and data may be missing."""

import itertools
import json

import numpy as np
import pytest
from figures.figure_9 import compute, plot


@pytest.fixture(scope="module")
def found():
    return json.loads((compute.FOLDER / "results.json").read_text())


def test_the_best_and_the_worst_materials_are_shown(found):
    under = {
        name: np.mean([m["code"][coats] for coats in list(compute.COATS)[1:]])
        for name, m in found["materials"].items()
    }
    names = compute.shown(found["materials"])
    assert names == found["shown"]
    assert names[0] == min(under, key=under.get) and names[-1] == max(under, key=under.get)


def test_without_data_the_figure_is_skipped_in_one_sentence(monkeypatch, capsys):
    monkeypatch.delenv("URUSHI_TEST_DATA", raising=False)
    compute.main()
    said = capsys.readouterr().out
    assert said.startswith("figure 9 is skipped") and said.count("\n") == 1
    plot.main()
    assert capsys.readouterr().out == ""


@pytest.mark.skipif(not compute.materials(), reason="URUSHI_TEST_DATA names no measured data")
def test_a_new_computation_of_one_material_has_the_stored_errors(found):
    (material,) = (m for m in compute.materials() if m.name == found["shown"][0])
    again = compute.errors(material, walks=1 << 10)
    stored = found["materials"][material.name]
    for form, coats in itertools.product(compute.FORMS, compute.COATS):
        # Noise adds to the mean of absolute differences at most what the walk's own error is.
        high = stored[form][coats] + again["noise"][coats]
        low = stored[form][coats] - stored["noise"][coats]
        assert low - 1e-3 < again[form][coats] < high + 1e-3


def test_tables_are_closer_than_codes_under_a_clear_coat(found):
    for material in found["materials"].values():
        assert material["table"]["clear coat"] < material["code"]["clear coat"]
