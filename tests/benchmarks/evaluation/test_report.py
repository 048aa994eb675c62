"""The table has every row and the same figures as the JSON file, and bad input is refused."""

import json
import sys

import numpy as np
import pytest
from benchmarks.evaluation import __main__, benchmark, physical_laws, report
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Row
from benchmarks.quality import benchmark_set

from urushi.errors import FileError
from urushi.nets import weights

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


def test_the_text_has_every_line(result):
    text = report.table(result)
    lines = {line.strip()[:22].strip(): line for line in text.splitlines()}
    for name in ("encode bare ones", "encode simulated ones", "all together", "layerer"):
        assert name in lines
    for law in result.laws:
        assert law.name in text
    mean = 100 * result.rows["all together"]["E"]["mean"]
    assert f"{mean:.2f}" in lines["all together"]


def test_parameters_are_counted(result, tiny):
    """Of all arrays in the file, by part."""
    counted = dict.fromkeys(("basis", "layerer", "proposal"), 0)
    for name, value in tiny.params.items():
        counted[name.split(".")[0]] += value.size
    assert result.parameters == counted


def test_json_has_the_same_figures(result, tmp_path):
    report.write_json(tmp_path / "f.json", result)
    written = json.loads((tmp_path / "f.json").read_text())
    assert written["rows"] == result.rows
    assert [law["kept"] for law in written["laws"]] == [law.kept for law in result.laws]
    assert written["errors"]["few"] == result.errors["few"].tolist()


def test_report_reads_the_weights_and_writes_the_folder(result, sets, tiny, tmp_path, monkeypatch):
    seen = {}

    def measure(model, used):
        seen.update(model=model, used=used)
        return result

    monkeypatch.setattr(report, "measure", measure)
    monkeypatch.setattr(benchmark, "read", lambda: sets)
    weights.save(tmp_path / "w.safetensors", tiny.arch, tiny.params, {})
    text = report.report(tmp_path / "w.safetensors", tmp_path / "new" / "figures")
    assert seen["model"].fingerprint == tiny.fingerprint and seen["used"] is sets
    names = {path.name for path in (tmp_path / "new" / "figures").iterdir()}
    assert names == {"figures.json"} and text == report.table(result)


def test_bad_input(sets, groups, tmp_path):
    with pytest.raises(FileError, match=r"missing\.safetensors"):
        report.report(tmp_path / "missing.safetensors")
    foreign = tmp_path / "foreign.safetensors"
    benchmark_set.write(foreign, sets, groups)
    with pytest.raises(FileError, match="is a safetensors file, but not one of Urushi's weights"):
        report.report(foreign)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(FileError, match="cannot create the folder"):
        report.report(output=tmp_path / "file")


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
