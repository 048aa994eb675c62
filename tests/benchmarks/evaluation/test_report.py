"""The rows are the figures of the networks."""

import numpy as np
import pytest
from benchmarks.evaluation import fan2022, physical_laws, predict, report
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Row

ROWS = (
    Row("encode bare ones", ("bare",)),
    Row("encode simulated ones", ("few",), encoded=-1),
    Row("all together", ("bare", "few")),
)


def test_rows_are_the_figures_of_the_networks(tiny, sets, groups, monkeypatch):
    monkeypatch.setattr(physical_laws, "WHITE_STACKS", 1)
    monkeypatch.setattr(physical_laws, "absorption", lambda model: [])
    result = report.measure(tiny, sets, groups=groups, rows=ROWS)
    e, p = [], []
    for samples in sets.values():
        f_hat = predict.evaluate(predict.materials(tiny, samples), samples.wi, samples.wo)
        e.append(sampling.stack_errors(f_hat, samples))
        p.append(sampling.pair_errors(f_hat, samples).ravel())
    row = result["rows"]["all together"]
    assert row["stacks"] == 6
    for metric, errors in (("E", e), ("P", p)):
        expected = report.summary(np.concatenate(errors))
        assert {k: row[metric][k] for k in expected} == pytest.approx(expected, rel=1e-9)
    exact = result["rows"]["encode bare ones"]["E"]
    assert row["E"]["reference"] < 0.01 and exact["reference"] == 0
    shown = report.errors_table(result["rows"])
    assert f"| {report.quantiles(row['E'])} |" in shown and shown.count("\n") == 1 + len(ROWS)


def test_a_missing_file_of_networks_is_one_sentence(capsys):
    with pytest.raises(SystemExit) as caught:
        fan2022.main(["nothing"])
    assert caught.value.code == 2
    assert "there is no weights file 'nothing'" in capsys.readouterr().err


def test_summary_of_one_to_hundred():
    expected = {"mean": 50, "median": 50, "p95": 95}
    assert report.summary(np.arange(101.0)) == pytest.approx(expected)
