"""`urushi data` and `urushi train` pass their flags to the packages that do the work."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from urushi.app import cli

pytest.importorskip("jax", reason="the extra 'train' is not installed")

from urushi.train import presets, tables, training


def test_data_are_computed_or_completed(monkeypatch, tmp_path, capsys):
    calls = []

    def generate(spec, path, cluster):
        calls.append((spec, path, cluster))
        return SimpleNamespace(hash=lambda: "0123")

    monkeypatch.setattr(tables, "generate", generate)
    assert cli.main(["data", "--preset", "smoke", "-o", str(tmp_path), "--cluster", "local:2"]) == 0
    assert calls == [(presets.smoke().data, tmp_path, "local:2")]
    assert capsys.readouterr().out == f"{tmp_path}  0123\n"


def test_train_passes_its_flags(monkeypatch, capsys):
    calls = {}

    model = SimpleNamespace(header={"metrics": {"E mean": 0.0123}}, fingerprint="0123456789ab")

    def train(preset, **options):
        calls.update(options, preset=preset)
        return model

    monkeypatch.setattr(training, "train", train)
    flags = ["--preset", "smoke", "--data", "d", "--run-folder", "r", "-o", "w.safetensors"]
    flags += ["--cluster", "local:2"]
    assert cli.main(["train", *flags, "--resume"]) == 0
    assert calls == {
        "preset": "smoke",
        "data": Path("d"),
        "run": Path("r"),
        "out": Path("w.safetensors"),
        "resume": True,
        "cluster": "local:2",
    }
    text = capsys.readouterr().out
    assert "0.0123" in text
    assert "0123456789ab" in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["data", "--preset", "slow", "-o", "x"], "there is no preset 'slow'"),
        (["train", "--preset", "slow"], "there is no preset 'slow'; choose one of"),
    ],
)
def test_errors(arguments, sentence, capsys):
    assert cli.main(arguments) == 2
    assert sentence in capsys.readouterr().err


def test_a_missing_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "optax", None)
    assert cli.main(["train"]) == 2
    assert "pip install 'jax<1,>=0.6' 'optax<1,>=0.2.4'" in capsys.readouterr().err
