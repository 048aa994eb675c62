"""Saved materials come back, know their weights, and hostile files are refused."""

import numpy as np
import pytest

from urushi import files
from urushi.core.table import SHAPE
from urushi.errors import FileError
from urushi.material import encode, load
from urushi.material.material import FORMAT_VERSION
from urushi.nets import weights
from urushi.walk import conductor


def test_round_trip(every, tmp_path):
    first, second = tmp_path / "a.safetensors", tmp_path / "b.safetensors"
    every.save(first)
    again = load(first, every.model)
    assert again == every and hash(again) == hash(every)
    assert again.beside_lobe == every.beside_lobe
    again.save(second)
    assert first.read_bytes() == second.read_bytes()


def test_other_weights_are_refused_by_name(material, model, other_model, tmp_path):
    path = tmp_path / "a.safetensors"
    material.save(path)
    with pytest.raises(FileError, match="does not match the weights") as caught:
        load(path, other_model)
    for part in (
        str(path),
        model.fingerprint,
        other_model.fingerprint,
        "encode the material again",
    ):
        assert part in str(caught.value)


@pytest.mark.parametrize(
    "arrays",
    [
        {"codes": np.ones((3, 14), np.float32)},
        {"latents": np.ones((3, 13), np.float32)},
        {"latents": np.ones((0, 14), np.float32)},
        {"latents": np.ones((3, 14), np.int32)},
        {"latents": np.full((3, 14), np.inf, np.float32)},
        {"latents": np.ones((3, 14), np.float32), "coat": np.ones((5, 1))},
        {"latents": np.ones((3, 14), np.float32), "table": np.zeros((*SHAPE, 1), np.float16)},
        {"latents": np.ones((3, 14), np.float32), "table": np.full((*SHAPE, 3), np.nan)},
        {"latents": np.ones((3, 14), np.float32), "table": np.full((*SHAPE, 3), 6e4, np.float16)},
        {"latents": np.ones((3, 14), np.float32), "table": np.full((*SHAPE, 3), -26, np.float16)},
    ],
)
def test_damaged_files_are_refused(arrays, model, tmp_path):
    path = tmp_path / "a.safetensors"
    description = {"version": FORMAT_VERSION, "weights": model.fingerprint}
    files.write_tensors(path, "material", description, arrays)
    with pytest.raises(FileError, match="is damaged: .*; copy or write it again"):
        load(path, model)


def test_a_file_whose_description_of_a_bottom_is_none_is_damaged(model, tmp_path):
    path = tmp_path / "a.safetensors"
    description = {"version": FORMAT_VERSION, "weights": model.fingerprint, "bottom": None}
    latents = np.ones((3, 14), np.float32)
    coat = np.array([[0.1], [1.5], [0.0], [0.0], [0.0]])
    arrays = {"latents": latents, "bottom.latents": latents, "coat": coat}
    files.write_tensors(path, "material", description, arrays)
    with pytest.raises(FileError, match="is damaged: .*; copy or write it again"):
        load(path, model)


def test_files_of_another_version_are_refused(material, model, tmp_path):
    path = tmp_path / "a.safetensors"
    description = {"version": FORMAT_VERSION + 1, "weights": model.fingerprint}
    files.write_tensors(path, "material", description, {"latents": material.latents})
    with pytest.raises(FileError, match=f"version {FORMAT_VERSION + 1}"):
        load(path, model)


def test_missing_and_unwritable_paths_are_named(material, model, tmp_path):
    with pytest.raises(FileError, match="there is no material file"):
        load(tmp_path / "absent.safetensors", model)
    with pytest.raises(FileError, match="cannot write"):
        material.save(tmp_path / "absent" / "a.safetensors")
    assert list(tmp_path.iterdir()) == []


def test_a_file_without_weights_belongs_to_the_shipped_ones(tmp_path):
    source = encode(conductor(0.3, 0.9))
    source.save(tmp_path / "metal")
    assert load(tmp_path / "metal") == source
    assert load(tmp_path / "metal").model is weights.default_model()
