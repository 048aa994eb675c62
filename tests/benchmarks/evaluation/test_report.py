"""The table has every row and the same figures as the JSON file, and bad input is refused."""

import sys

import numpy as np
import pytest
from benchmarks.evaluation import __main__, physical_laws, report
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Row

ROWS = (
    Row("encode bare ones", ("bare",)),
    Row("encode simulated ones", ("few",), encoded=-1),
    Row("all together", ("bare", "few")),
)


@pytest.fixture(scope="module")
def result(tiny, sets, groups):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(physical_laws, "WHITE_STACKS", 1)
        patch.setattr(physical_laws, "absorption", lambda model: [])
        return report.measure(tiny, sets, groups=groups, rows=ROWS)


def test_rows_are_the_figures_of_the_networks(result, tiny, sets):
    from benchmarks.evaluation import predict

    e, p = [], []
    for samples in sets.values():
        f_hat = predict.evaluate(predict.materials(tiny, samples), samples.wi, samples.wo)
        e.append(sampling.stack_errors(f_hat, samples))
        p.append(sampling.pair_errors(f_hat, samples).ravel())
    row = result.rows["all together"]
    assert row["stacks"] == 6
    for metric, errors in (("E", e), ("P", p)):
        expected = report.summary(np.concatenate(errors))
        assert {k: row[metric][k] for k in expected} == pytest.approx(expected, rel=1e-9)
    assert row["E"]["reference"] < 0.01 and result.rows["encode bare ones"]["E"]["reference"] == 0
    assert set(result.errors) == {"bare", "few"}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--fan2022"], "--fan2022 needs --weights, a file of its networks"),
        (["--fan2022", "--weights", "nothing"], "there is no weights file 'nothing'"),
        (["--weights", "nothing"], "there are no weights 'nothing'"),
    ],
)
def test_errors_of_the_command_are_one_sentence(arguments, sentence, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["evaluation", *arguments])
    with pytest.raises(SystemExit) as caught:
        __main__.main()
    assert caught.value.code == 2
    assert sentence in capsys.readouterr().err
