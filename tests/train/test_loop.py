"""Whole trainings: bit-exact resumption, the weights' header, figures, and errors."""

import dataclasses
import json
import shutil

import numpy as np
import pytest

from urushi.errors import FileError, ParameterError
from urushi.nets import weights
from urushi.train import presets, training
from urushi.train.checkpoint import Checkpoint, Journal
from urushi.train.optimiser import Schedule
from urushi.train.training import train


@pytest.fixture(scope="module")
def whole(tiny, store, tmp_path_factory):
    """A model, its run folder, and a copy of the folder as an interruption would have left it.

    That is after the first checkpoint.
    """
    parent = tmp_path_factory.mktemp("whole")
    folder, copy, save = parent / "run", parent / "copy", Journal.save

    def copied(self, *arguments):
        if self.begun() and not copy.exists():
            shutil.copytree(folder, copy)
        save(self, *arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Journal, "save", copied)
        model = train(tiny, data=store.path, out=folder / "weights.safetensors", run=folder)
    return model, folder, copy


def log(folder):
    lines = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
    return [{k: v for k, v in line.items() if k != "seconds"} for line in lines]


def test_an_interrupted_training_resumes_to_the_same_bits(whole, tiny, store, tmp_path):
    model, folder, copy = whole
    shutil.copytree(copy, tmp_path / "run")
    resumed = train(tiny, data=store.path, run=tmp_path / "run", resume=True)
    assert resumed.fingerprint == model.fingerprint
    assert log(tmp_path / "run") == log(folder)


def test_the_time_of_the_data_is_kept_over_interruptions(tmp_path):
    """A resumed run finds its data complete; the header still states what they cost."""
    point = Checkpoint("layering", 1, 3.0, {"weight": np.ones(2, np.float32)}, {})
    Journal(tmp_path, {}, data_seconds=100.0).save(point)
    resumed = Journal(tmp_path, {}, data_seconds=2.0)
    assert resumed.restore({"layering": point}).seconds == 3
    assert resumed.data_seconds == 102


def test_the_header_states_the_origin_of_the_weights(whole, tiny, store):
    model, folder, _ = whole
    read = weights.read(folder / "weights.safetensors")
    header = read.header
    assert read.fingerprint == model.fingerprint
    assert header["preset"]["name"] == "tiny" and header["preset"]["schedule"]["steps"] == 8
    assert header["seed"] == tiny.seed and header["data"] == store.hash()
    assert "E of codes, mean" in header["metrics"]
    assert set(header["versions"]) == {"urushi", "python", "jax", "optax", "numpy"}
    assert {"data seconds", "training seconds", "processors"} <= set(header["cost"])


def test_metrics_are_those_of_the_written_weights(whole, tiny, store):
    """Of stacks that are held out: the network's errors, by its own parameters."""
    model = whole[0]
    found, stacks = training.layerings(model, store)
    hidden = found.taken(stacks % training.HELD_OUT == 0)
    figures = training.measure(model.params, tiny, hidden)
    told = {name: model.header["metrics"][name] for name in figures}
    assert told == pytest.approx(figures, rel=1e-3)


def test_an_interrupted_training_is_not_overwritten(whole, tiny, store):
    with pytest.raises(FileError, match="contains a training already; give --resume"):
        train(tiny, data=store.path, run=whole[1])


def test_a_foreign_or_damaged_checkpoint_is_refused(whole, tiny, store, tmp_path, monkeypatch):
    """Before anything is fitted."""
    monkeypatch.setattr(training, "fitted_basis", None)
    shutil.copy(whole[1] / "checkpoint.safetensors", tmp_path)
    with pytest.raises(FileError, match="is a checkpoint of another preset, data or version"):
        train(dataclasses.replace(tiny, seed=9), data=store.path, run=tmp_path, resume=True)
    file = tmp_path / "checkpoint.safetensors"
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(FileError, match="is truncated"):
        train(tiny, data=store.path, run=tmp_path, resume=True)


def test_unwritable_paths_are_refused_before_the_training(tiny, store, tmp_path):
    (tmp_path / "file").write_text("text")
    with pytest.raises(FileError, match="cannot create the folder"):
        train(tiny, data=store.path, run=tmp_path / "file" / "run")
    with pytest.raises(FileError, match="it is a folder; give the name of a file"):
        train(tiny, data=store.path, run=tmp_path / "run", out=tmp_path)


@pytest.mark.parametrize("name", presets.NAMES)
def test_presets_state_their_command_time_and_figures(name):
    preset = presets.get(name)
    assert preset.name == name
    for words in (f"urushi train --preset {name}", "Time:", "Expected"):
        assert words in presets._PRESETS[name].__doc__


def test_schedules_must_divide():
    with pytest.raises(ParameterError, match="steps is 10; it must be a multiple of its 4"):
        Schedule(10, 1, 1e-3, steps_per_call=4)
