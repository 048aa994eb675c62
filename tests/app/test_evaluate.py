"""`urushi eval` and `urushi data benchmark` pass their flags to the evaluation."""

import sys
from pathlib import Path

import pytest

from urushi.app import cli
from urushi.eval import benchmark, report


@pytest.fixture
def calls(monkeypatch) -> dict:
    """What the evaluation was asked for; nothing is measured."""
    calls: dict = {}

    def table(weights, output, *, seed):
        calls.update(weights=weights, output=output, seed=seed)
        return "the table"

    monkeypatch.setattr(report, "report", table)
    monkeypatch.setattr(
        benchmark, "make", lambda path, keep: calls.update(path=path, keep=keep) or "0123"
    )
    return calls


def test_eval_uses_the_stored_set_unless_a_seed_is_given(calls, capsys):
    assert cli.main(["eval"]) == 0
    assert calls == {"weights": None, "output": None, "seed": None}
    assert capsys.readouterr().out == "the table\n"
    assert cli.main(["eval", "--weights", "w.safetensors", "--seed", "3"]) == 0
    assert calls == {"weights": "w.safetensors", "output": None, "seed": 3}


def test_benchmark(calls, capsys):
    assert cli.main(["data", "benchmark", "-o", "b.safetensors"]) == 0
    assert calls == {"path": Path("b.safetensors"), "keep": None}
    assert capsys.readouterr().out == "b.safetensors  0123\n"
    assert cli.main(["data", "benchmark", "-o", "b.safetensors", "--keep", "a.safetensors"]) == 0
    assert calls == {"path": Path("b.safetensors"), "keep": Path("a.safetensors")}


def test_plots_need_their_extra(calls, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert cli.main(["eval", "-o", "figures"]) == 2
    assert "pip install 'urushi[eval]'" in capsys.readouterr().err
    assert calls == {}


def test_errors(capsys):
    assert cli.main(["eval", "--weights", "nowhere.safetensors"]) == 2
    assert "there are no weights 'nowhere.safetensors'" in capsys.readouterr().err
