"""`urushi eval` passes its flags to the evaluation."""

from pathlib import Path

import pytest

from urushi.app import cli
from urushi.eval import report


@pytest.fixture
def calls(monkeypatch) -> dict:
    """What the evaluation was asked for; nothing is measured."""
    calls: dict = {}

    def table(weights, output):
        calls.update(weights=weights, output=output)
        return "the table"

    monkeypatch.setattr(report, "report", table)
    return calls


def test_eval_passes_its_flags(calls, capsys):
    assert cli.main(["eval"]) == 0
    assert calls == {"weights": None, "output": None}
    assert capsys.readouterr().out == "the table\n"
    assert cli.main(["eval", "--weights", "w.safetensors", "-o", "out"]) == 0
    assert calls == {"weights": "w.safetensors", "output": Path("out")}


def test_errors(capsys):
    assert cli.main(["eval", "--weights", "nowhere.safetensors"]) == 2
    assert "there are no weights 'nowhere.safetensors'" in capsys.readouterr().err
