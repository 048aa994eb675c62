"""Experiments: stored results and the docs, stopped runs, intervals, and the faulty walks."""

import json

import numpy as np
import pytest
from benchmarks import experiment, showing
from benchmarks.__main__ import main
from benchmarks.experiment import Experiment, Options
from benchmarks.experiments import simulator_biases
from tests.oracles.analog import analog_albedo

import urushi
from urushi.walk.simulate import albedo


def test_the_docs_show_the_stored_results_and_which_are_stale():
    """If this fails, results or weights have changed: run `python -m benchmarks pages`."""
    for page, text in experiment.shown().items():
        assert page.read_text() == text, page


def test_every_stored_result_belongs_to_an_experiment_with_tables():
    stored = {path.stem for path in experiment.FIGURES.glob("*.json")}
    assert stored <= set(experiment.names())
    for name in experiment.names():
        one = experiment.load(name)
        assert one.cases(Options()).keys() or name == "figure_9"
        if name in stored:
            assert all(one.tables(experiment.stored(name)["cases"]))


def test_results_of_other_weights_are_stale(monkeypatch):
    found = experiment.stored("accuracy")
    assert experiment.state("accuracy") == ""
    other = found | {"weights": {"weights": "0" * 12}}
    monkeypatch.setattr(experiment, "stored", lambda name: other)
    assert experiment.state("accuracy") == "stale"
    assert "| stale |" in experiment.states() and "`accuracy`" in experiment.stale()
    assert experiment.STALE.fullmatch(experiment.stale())


@pytest.fixture
def counting(monkeypatch, tmp_path):
    """An experiment of two cases, the second of which fails once; and the cases measured."""
    calls: list[str] = []

    def measure(case, options):
        calls.append(case)
        if calls == ["a", "b"]:
            raise RuntimeError("stopped")
        return {"value": case}, {"picture": np.ones((1, 1, 2))}

    one = Experiment(
        cases=lambda options: {"first": "a", "second": "b"},
        measure=measure,
        tables=lambda found: [showing.table(["case"], [[name] for name in found])],
        plot=lambda found, pictures: showing.figure(*pictures("first")["picture"][0, 0]),
        pages=(),
    )
    monkeypatch.setattr(experiment, "load", lambda name: one)
    for name in ("FIGURES", "PARTS"):
        monkeypatch.setattr(experiment, name, tmp_path)
    return calls


def test_finished_cases_are_read_and_whole_runs_are_stored(counting, tmp_path):
    with pytest.raises(RuntimeError):
        experiment.run("new", Options())
    assert not (tmp_path / "new.json").exists()
    found = experiment.run("new", Options())
    assert counting == ["a", "b", "b"]
    assert found == {"first": {"value": "a"}, "second": {"value": "b"}}
    stored = json.loads((tmp_path / "new.json").read_text())
    assert stored["cases"] == found and stored["weights"] == {} and (tmp_path / "new.png").exists()
    experiment.run("new", Options(share=0.5), ["first"])  # other options have other files
    assert counting == ["a", "b", "b", "a"]
    assert json.loads((tmp_path / "new.json").read_text()) == stored


@pytest.mark.parametrize(
    ("known", "chosen", "reason"),
    [({}, (), "give --files"), ({"first": 1}, ("third",), "none of third; choose from first")],
)
def test_without_cases_a_run_says_why_alone(monkeypatch, capsys, known, chosen, reason):
    """It neither measures nor shows a table."""
    one = Experiment(cases=lambda options: known, measure=None, tables=None)
    monkeypatch.setattr(experiment, "load", lambda name: one)
    main(("proposal",), options=Options(share=0.5), cases=chosen)
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("proposal has no cases: ") and reason in line


def test_a_table_is_replaced_whole_and_the_text_beside_it_stays():
    old = showing.table(["a", "b"], [["1", "2"]])
    new = showing.table(["a", "b"], [["3", "4"], ["5", "6"]])
    assert new == "| a | b |\n|---|---|\n| 3 | 4 |\n| 5 | 6 |"
    other = showing.table(["a", "c"], [["7", "8"]])
    text = f"One.\n\n{{}}\n\nTwo.\n\n{other}\n"
    assert experiment.replaced(text.format(old), new) == text.format(new)
    with pytest.raises(ValueError, match="the page has 0 tables"):
        experiment.replaced(other, new)


def test_the_interval_covers_the_mean_as_often_as_it_says():
    # 400 samples of 40 normal numbers: the share has a standard error of 1.1 %, and the percentile
    # method is short by about 1 % at this size.
    draws = np.random.default_rng(3).normal(size=(400, 40))
    inside = [low <= 0 <= high for low, high in map(showing.interval, draws)]
    assert showing.COVERAGE - 0.045 < np.mean(inside) < showing.COVERAGE + 0.033


@pytest.mark.parametrize("alpha", [0.01, 0.5])
def test_faults_of_walks_move_energy_as_the_page_says(alpha):
    mirror = urushi.conductor(alpha=alpha, r0=1)
    stack = urushi.coat(mirror, alpha, 1.5, albedo=1, sigma_t=0)
    wi = simulator_biases.WI
    expected, error = (x[0, 0] for x in analog_albedo(stack, wi, walks=1 << 20, seed=6))
    found = {}
    for name, variant in simulator_biases.VARIANTS.items():
        with variant():
            mean, se = albedo(stack, wi, walks=1 << 18, seed=5)
        found[name] = (mean[0, 0] - expected) / np.hypot(se[0, 0], error)
    assert abs(found["right"]) < 4
    assert found["reverse density"] > 10
    if alpha > 0.1:
        assert found["dropped connection"] < -10
