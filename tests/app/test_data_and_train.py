"""`urushi data` and `urushi train` pass their flags to the packages that do the work."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from urushi.app import cli

pytest.importorskip("jax", reason="the extra 'train' is not installed")
pytest.importorskip("jax", reason="the extra 'train' is not installed")

from urushi.fan2022.store import DataSpec, Part, Store
from urushi.train import presets, training
from urushi.train.distribution import Extended


@pytest.fixture
def tiny(monkeypatch) -> DataSpec:
    """A preset's data in the size of a test."""
    spec = DataSpec(
        (Part("coated", Extended(1), 3, 16, 2), Part("bare", Extended(0, "diffuse"), 2, 16, 1)),
        seed=5,
        shard=2,
    )

    monkeypatch.setattr(presets, "get", lambda name: SimpleNamespace(data=spec))
    monkeypatch.setattr(presets, "NAMES", ("tiny",))
    return spec


def test_data_are_generated(tiny, tmp_path, capsys):
    path = tmp_path / "tiny"
    assert cli.main(["data", "--preset", "tiny", "-o", str(path)]) == 0
    store = Store(path, tiny)
    assert store.missing() == []
    assert store.hash() in capsys.readouterr().out


def test_generate_resumes_to_the_same_store(tiny, tmp_path, capsys):
    path = tmp_path / "tiny"
    for _ in range(2):
        assert cli.main(["data", "--preset", "tiny", "-o", str(path)]) == 0
    first, second = capsys.readouterr().out.split("\n")[:2]
    assert first == second


def test_train_passes_its_flags(monkeypatch, capsys):
    calls = {}

    model = SimpleNamespace(header={"metrics": {"E mean": 0.0123}}, fingerprint="0123456789ab")

    def train(preset, **options):
        calls.update(options, preset=preset)
        return model

    monkeypatch.setattr(training, "train", train)
    flags = ["--preset", "smoke", "--data", "d", "--run-folder", "r", "-o", "w.safetensors"]
    assert cli.main(["train", *flags, "--resume"]) == 0
    assert calls == {
        "preset": presets.get("smoke"),
        "data": Path("d"),
        "run": Path("r"),
        "out": Path("w.safetensors"),
        "resume": True,
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
