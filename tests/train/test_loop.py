"""Whole trainings: bit-exact resumption, the weights' header, figures, and errors."""

import dataclasses
import json
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from urushi.core import error_metrics
from urushi.errors import FileError, ParameterError
from urushi.nets import lobe, weights
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import direction_features
from urushi.nets.layerer import layer
from urushi.train import presets, training
from urushi.train.checkpoint import Checkpoint, Journal
from urushi.train.optimiser import Schedule
from urushi.train.store import Store
from urushi.train.training import train


@pytest.fixture(scope="module")
def brief(tiny):
    """The preset with two of its stages."""
    joint, _, decoding, _, _ = tiny.stages
    return dataclasses.replace(tiny, stages=(joint, decoding), arch=tiny.architectures()[0])


@pytest.fixture(scope="module")
def uninterrupted(brief, tiny_data, tmp_path_factory):
    """The result of `train_and_copy` for two stages."""
    return train_and_copy(brief, tiny_data, tmp_path_factory.mktemp("brief"))


@pytest.fixture(scope="module")
def whole(tiny, tiny_data, tmp_path_factory):
    """The result of `train_and_copy` for all stages, which compile for half a minute."""
    return train_and_copy(tiny, tiny_data, tmp_path_factory.mktemp("whole"))


def train_and_copy(preset, data, parent):
    """A model, its run folder, and copies of that folder as interruptions would have left it.

    Copy k is made before save k + 1 (from k = 1 on).
    """
    folder, copies = parent / "run", parent / "copies"
    save, count = Journal.save, []

    def copied(self, point, *figures):
        if count:
            shutil.copytree(folder, copies / str(len(count)))
        count.append(point)
        save(self, point, *figures)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Journal, "save", copied)
        model = train(preset, data=data, out=folder / "weights.safetensors", run=folder)
    return model, folder, copies


def log(folder):
    lines = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
    return [{k: v for k, v in line.items() if k != "seconds"} for line in lines]


def test_an_interrupted_training_resumes_to_the_same_bits(
    uninterrupted, brief, tiny_data, tmp_path
):
    """Of two stages; from the change between them."""
    model, folder, copies = uninterrupted
    shutil.copytree(copies / "2", tmp_path / "run")
    resumed = train(brief, data=tiny_data, run=tmp_path / "run", resume=True)
    assert resumed.fingerprint == model.fingerprint
    assert log(tmp_path / "run") == log(folder)


@pytest.mark.research
@pytest.mark.parametrize(
    "saves",
    [
        pytest.param(2, id="before the layerer is widened"),
        pytest.param(4, id="within layering"),
        pytest.param(7, id="within decoding"),
        pytest.param(13, id="within sampling"),
    ],
)
def test_a_training_of_all_stages_resumes_to_the_same_bits(saves, whole, tiny, tiny_data, tmp_path):
    """Two checkpoints in every stage and one at each change of stage: 14 saves.

    The first save of all is tested by the killed process below.
    """
    model, folder, copies = whole
    run = tmp_path / "run"
    shutil.copytree(copies / str(saves), run)
    resumed = train(tiny, data=tiny_data, run=run, resume=True)
    assert resumed.fingerprint == model.fingerprint
    assert log(run) == log(folder)


@pytest.mark.research
def test_a_killed_process_resumes_to_the_same_bits(whole, tmp_path, tiny, tiny_data):
    script = (
        "import sys\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "from conftest import TINY\n"
        "from urushi.train.training import train\n"
        "train(TINY, data=sys.argv[2], run=sys.argv[3])\n"
    )
    here = str(__file__).rsplit("/", 1)[0]
    command = [sys.executable, "-c", script, here, str(tiny_data), str(tmp_path)]
    process = subprocess.Popen(command)
    deadline = time.monotonic() + 120
    while not (tmp_path / "checkpoint.safetensors").exists() and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert not (tmp_path / "weights.safetensors").exists()
    resumed = train(tiny, data=tiny_data, run=tmp_path, resume=True)
    assert resumed.fingerprint == whole[0].fingerprint


def test_the_time_of_the_data_is_kept_over_interruptions(tmp_path):
    """A resumed run finds its data complete; the header still states what they cost."""
    point = Checkpoint("joint", 1, 3.0, {"weight": np.ones(2, np.float32)}, {})
    Journal(tmp_path, {}, data_seconds=100.0).save(point)
    resumed = Journal(tmp_path, {}, data_seconds=2.0)
    assert resumed.restore({"joint": point}).seconds == 3
    assert resumed.data_seconds == 102


def test_stages_are_optional(uninterrupted):
    model, folder, _ = uninterrupted
    lines = log(folder)
    assert list(dict.fromkeys(line["stage"] for line in lines)) == ["joint", "decoding"]
    assert [stage["kind"] for stage in model.header["preset"]["stages"]] == ["joint", "decoding"]
    assert set(model.header["metrics"]) == {"E mean", "P median"}


def test_the_header_states_the_origin_of_the_weights(uninterrupted, brief, tiny_data):
    model, folder, _ = uninterrupted
    read = weights.read(folder / "weights.safetensors")
    assert read.fingerprint == model.fingerprint
    header = read.header
    assert header["preset"]["name"] == "tiny"
    assert header["preset"]["stages"][0]["schedule"]["steps"] == 8
    assert header["seed"] == brief.seed
    assert header["data"] == Store(tiny_data, brief.data).hash()
    assert set(header["metrics"]) == {"E mean", "P median"}
    assert set(header["versions"]) == {"urushi", "python", "jax", "optax", "numpy"}
    assert {"data seconds", "training seconds", "processors"} <= set(header["cost"])


def test_validation_measures_the_exported_weights(uninterrupted, brief, tiny_data):
    model = uninterrupted[0]
    store = Store(tiny_data, brief.data)
    checks = training.load_checks(store, brief.arch)
    figures = training.measure(model.params, brief.arch, checks)
    values = []
    for check, part in zip(checks, store.spec.parts[4:6], strict=True):
        wi, wo = (store.read(part)[name] for name in ("wi", "wo"))
        held = check.examples
        codes = encode(model.params, brief.arch, held.probes)
        z = np.concatenate([held.lobes, codes], axis=-1)
        z = layer(model.params, brief.arch, z, tuple(held.coats[:, 0].T))
        top = lobe.f(z[:, None, :6], wi, wo)
        values.append(top + decode(model.params, brief.arch, z[:, None, 6:], held.features))
    arrays = store.read(store.spec.parts[4])
    wi, wo = arrays["wi"], arrays["wo"]
    np.testing.assert_array_equal(checks[0].examples.features, direction_features(wi, wo))
    e = error_metrics.stack_error(values[0], arrays["f"], wi[..., 2], wo[..., 2]).mean()
    p = np.median(error_metrics.pair_error(values[1], store.read(store.spec.parts[5])["f"]))
    assert figures == pytest.approx({"E mean": e, "P median": p}, rel=1e-4)  # float32 sums


def test_an_interrupted_training_is_not_overwritten(uninterrupted, brief, tiny_data):
    folder = uninterrupted[1]
    with pytest.raises(FileError, match="contains an unfinished training; give --resume"):
        train(brief, data=tiny_data, run=folder)


def test_a_checkpoint_of_another_preset_or_a_damaged_one_is_refused(
    uninterrupted, brief, tiny_data, tmp_path
):
    shutil.copy(uninterrupted[1] / "checkpoint.safetensors", tmp_path)
    with pytest.raises(FileError, match="is a checkpoint of another preset, data or version"):
        train(dataclasses.replace(brief, seed=9), data=tiny_data, run=tmp_path, resume=True)
    file = tmp_path / "checkpoint.safetensors"
    file.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(FileError, match="is truncated"):
        train(brief, data=tiny_data, run=tmp_path, resume=True)


def test_unwritable_paths_are_refused_before_the_training(tiny, tiny_data, tmp_path):
    (tmp_path / "file").write_text("text")
    with pytest.raises(FileError, match="cannot create the folder"):
        train(tiny, data=tiny_data, run=tmp_path / "file" / "run")
    with pytest.raises(FileError, match="it is a folder; give the name of a file"):
        train(tiny, data=tiny_data, run=tmp_path / "run", out=tmp_path)


def test_errors_name_unknown_presets():
    with pytest.raises(
        ParameterError, match="no preset 'slow'; choose one of default, anisotropic"
    ):
        train("slow")


@pytest.mark.parametrize("name", presets.NAMES)
def test_presets_state_their_command_time_and_figures(name):
    preset = presets.get(name)
    assert preset.name == name
    text = presets._PRESETS[name].__doc__
    assert f"urushi train --preset {name}" in text
    assert "Time:" in text
    assert "Expected" in text


def test_schedules_must_divide():
    with pytest.raises(ParameterError, match="steps is 10; it must be a multiple of its 4"):
        Schedule(10, 1, 1e-3, steps_per_call=4)
