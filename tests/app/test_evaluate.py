"""`urushi eval` passes its flags to the evaluation."""

import sys

import pytest

from urushi.app import cli
from urushi.eval import report


@pytest.fixture
def calls(monkeypatch) -> dict:
    """What the evaluation was asked for; nothing is measured."""
    calls: dict = {}

    def table(weights, output, *, seed):
        calls.update(weights=weights, output=output, seed=seed)
        return "the table"

    monkeypatch.setattr(report, "report", table)
    return calls


def test_eval_uses_the_stored_set_unless_a_seed_is_given(calls, capsys):
    assert cli.main(["eval"]) == 0
    assert calls == {"weights": None, "output": None, "seed": None}
    assert capsys.readouterr().out == "the table\n"
    assert cli.main(["eval", "--weights", "w.safetensors", "--seed", "3"]) == 0
    assert calls == {"weights": "w.safetensors", "output": None, "seed": 3}


def test_plots_need_their_extra(calls, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert cli.main(["eval", "-o", "figures"]) == 2
    assert "pip install 'urushi[eval]'" in capsys.readouterr().err
    assert calls == {}


def test_errors(capsys):
    assert cli.main(["eval", "--weights", "nowhere.safetensors"]) == 2
    assert "there are no weights 'nowhere.safetensors'" in capsys.readouterr().err
