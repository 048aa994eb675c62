"""`urushi data` and `urushi train` pass their flags to the packages that do the work."""

import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from urushi.app import cli

pytest.importorskip("jax", reason="the extra 'train' is not installed")

from urushi.train import presets, tables, training


def test_data_are_computed_or_completed(monkeypatch, tmp_path, capsys):
    generate = Mock(return_value=SimpleNamespace(hash=lambda: "0123"))
    monkeypatch.setattr(tables, "generate", generate)
    assert cli.main(["data", "--preset", "smoke", "-o", str(tmp_path), "--cluster", "local:2"]) == 0
    generate.assert_called_once_with(presets.smoke().data, tmp_path, cluster="local:2")
    assert capsys.readouterr().out == f"{tmp_path}  0123\n"


def test_train_passes_its_flags(monkeypatch, capsys):
    model = SimpleNamespace(header={"metrics": {"E mean": 0.0123}}, fingerprint="0123456789ab")
    monkeypatch.setattr(training, "train", train := Mock(return_value=model))
    flags = ["--preset", "smoke", "--data", "d", "--run-folder", "r", "-o", "w.safetensors"]
    assert cli.main(["train", *flags, "--cluster", "local:2", "--resume"]) == 0
    paths = {"data": Path("d"), "run": Path("r"), "out": Path("w.safetensors")}
    train.assert_called_once_with("smoke", **paths, resume=True, cluster="local:2")
    assert capsys.readouterr().out == "E mean  0.0123\nfingerprint  0123456789ab\n"


@pytest.mark.parametrize("arguments", [["data", "-o", "x"], ["train"]])
def test_errors(arguments, monkeypatch, capsys):
    """An unknown preset, and an extra that is not installed."""
    assert cli.main([*arguments, "--preset", "slow"]) == 2
    assert "there is no preset 'slow'; choose one of" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "optax", None)
    assert cli.main(arguments) == 2
    assert "pip install 'jax<1,>=0.6' 'optax<1,>=0.2.4'" in capsys.readouterr().err
