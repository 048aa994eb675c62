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
    parts = path, "does not match the weights", model.fingerprint, other_model.fingerprint
    with pytest.raises(FileError, match=".*".join(map(str, parts)) + ".*encode the material again"):
        load(path, other_model)


CODES, COAT = {"latents": np.ones((3, 14), np.float32)}, [[0.1], [1.5], [0.0], [0.0], [0.0]]
COATED = CODES | {"bottom.latents": CODES["latents"], "coat": np.array(COAT)}


@pytest.mark.parametrize(
    ("arrays", "description"),
    [
        ({"codes": np.ones((3, 14), np.float32)}, {}),
        ({"latents": np.ones((3, 13), np.float32)}, {}),
        ({"latents": np.ones((0, 14), np.float32)}, {}),
        ({"latents": np.ones((3, 14), np.int32)}, {}),
        ({"latents": np.full((3, 14), np.inf, np.float32)}, {}),
        (CODES | {"coat": np.ones((5, 1))}, {}),
        (CODES | {"table": np.zeros((*SHAPE, 1), np.float16)}, {}),
        (CODES | {"table": np.full((*SHAPE, 3), np.nan)}, {}),
        (CODES | {"table": np.full((*SHAPE, 3), 6e4, np.float16)}, {}),
        (CODES | {"table": np.full((*SHAPE, 3), -26, np.float16)}, {}),
        (COATED, {"bottom": None}),
        (COATED | {"coat": np.repeat(COAT, 2, axis=1)}, {"bottom": {}}),
        (COATED | {"coat": np.reshape(COAT, (5, 1, 1))}, {"bottom": {}}),
        (COATED | {"coat": np.array([*COAT, [0.1]])}, {"bottom": {}}),
        (COATED | {"bottom.latents": np.ones((1, 14), np.float32)}, {"bottom": {}}),
        (CODES, {"version": FORMAT_VERSION + 1}),
    ],
)
def test_damaged_files_and_those_of_other_versions_are_refused(
    arrays, description, model, tmp_path
):
    path = tmp_path / "a.safetensors"
    whole = {"version": FORMAT_VERSION, "weights": model.fingerprint} | description
    files.write_tensors(path, "material", whole, arrays)
    words = "is damaged: .*; copy or write it again"
    if "version" in description:
        words = f"version {FORMAT_VERSION + 1}"
    with pytest.raises(FileError, match=words):
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
