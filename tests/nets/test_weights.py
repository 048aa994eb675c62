"""Weights files: a round trip, a fingerprint that means something, and hostile files."""

import json
import struct

import numpy as np
import pytest
import safetensors.numpy

from urushi.errors import FileError, ParameterError
from urushi.nets import weights
from urushi.nets.networks import Architecture

ARCH = Architecture(functions=3, layerer=(8,), probes=16)


def init(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Random parameters."""
    rng = np.random.default_rng(seed)
    shapes = arch.parameter_shapes().items()
    return {name: rng.normal(size=shape).astype(np.float32) for name, shape in shapes}


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "weights.safetensors"
    return path, weights.save(path, ARCH, init(ARCH, 0), {"preset": "quick", "seed": 0})


def test_round_trip(saved):
    path, model = saved
    again = weights.read(path)
    assert again.arch == ARCH and again.header == {"preset": "quick", "seed": 0}
    assert again.fingerprint == model.fingerprint
    assert all(np.array_equal(again.params[name], model.params[name]) for name in model.params)


def test_the_same_networks_make_the_same_bytes(saved, tmp_path):
    path, _ = saved
    other = tmp_path / "again.safetensors"
    weights.save(other, ARCH, init(ARCH, 0), {"seed": 0, "preset": "quick"})
    assert other.read_bytes() == path.read_bytes()


def test_fingerprint_sees_every_parameter_but_not_the_header(saved):
    _, model = saved
    assert weights.Model.of(ARCH, model.params, {}).fingerprint == model.fingerprint
    seen = {model.fingerprint}
    for name, value in model.params.items():
        changed = dict(model.params) | {name: value + np.float32(1e-3)}
        seen.add(weights.Model.of(ARCH, changed, {}).fingerprint)
    assert len(seen) == len(model.params) + 1


def test_a_model_does_not_change_with_what_it_was_made_from():
    params = init(ARCH, 0)
    model = weights.Model.of(ARCH, params, {})
    params["layerer.0.weight"][:] = 7
    assert not (model.params["layerer.0.weight"] == 7).any()
    with pytest.raises(ValueError, match="read-only"):
        model.params["layerer.0.weight"][0, 0] = 1


def _broken_parameters():
    good = init(ARCH, 0)
    missing = {name: value for name, value in good.items() if name != "layerer.1.bias"}
    not_finite = good | {"layerer.0.bias": np.full(8, np.nan, np.float32)}
    return {
        "'layerer.1.bias' is missing": missing,
        "'extra' is unknown": good | {"extra": np.zeros(1, np.float32)},
        "'layerer.0.bias' has shape": good | {"layerer.0.bias": np.zeros(9, np.float32)},
        "'layerer.0.bias' holds a number that is not finite": not_finite,
    }


@pytest.mark.parametrize("words", _broken_parameters())
def test_broken_parameters_are_refused(words, saved):
    params = _broken_parameters()[words]
    with pytest.raises(ParameterError, match=words):
        weights.Model.of(ARCH, params, {})
    path, _ = saved
    metadata = {"kind": "weights", "version": 1, "architecture": json.loads(ARCH.to_json())}
    path.write_bytes(safetensors.numpy.save(params, {"urushi": json.dumps(metadata)}))
    with pytest.raises(FileError, match=words):
        weights.read(path)


def _hostile(good: bytes) -> dict[str, bytes]:
    size = struct.unpack("<Q", good[:8])[0]
    header = json.loads(good[8 : 8 + size])
    tensors, text = good[8 + size :], header["__metadata__"]["urushi"]

    def with_metadata(metadata):
        changed = json.dumps(header | {"__metadata__": metadata}).encode()
        return struct.pack("<Q", len(changed)) + changed + tensors

    return {
        "empty": b"",
        "seven bytes": good[:7],
        "cut in the header": good[: 8 + size // 2],
        "cut in the tensors": good[:-5],
        "bytes at the end": good + b"more",
        "html": b"<!DOCTYPE html><html><body>404 Not Found</body></html>" * 20,
        "git lfs pointer": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n",
        "zip": b"PK\x03\x04" + bytes(500),
        "header claims 2^63 bytes": struct.pack("<Q", 1 << 63) + good[8:],
        "header claims 90 MB": struct.pack("<Q", 90_000_000) + good[8:],
        "header is no JSON": good[:8] + b"}" * size + tensors,
        "no metadata": safetensors.numpy.save({"a": np.zeros(3, np.float32)}),
        "foreign metadata": with_metadata({"format": "pt"}),
        "metadata no JSON": with_metadata({"urushi": "{"}),
        "metadata a list": with_metadata({"urushi": "[1]"}),
        "metadata nested deeply": with_metadata({"urushi": "[" * 100_000}),
        "another kind": with_metadata({"urushi": text.replace('"weights"', '"material"')}),
        "another version": with_metadata({"urushi": text.replace('"version": 1', '"version": 9')}),
        "no architecture": with_metadata({"urushi": '{"kind": "weights", "version": 1}'}),
        "huge architecture": with_metadata(
            {"urushi": text.replace('"probes": 16', '"probes": 1e9')}
        ),
    }


def _good() -> bytes:
    metadata = {"kind": "weights", "version": 1, "architecture": json.loads(ARCH.to_json())}
    return safetensors.numpy.save(init(ARCH, 0), {"urushi": json.dumps(metadata)})


@pytest.mark.parametrize("case", _hostile(_good()))
def test_hostile_files_are_refused_in_one_sentence(case, tmp_path):
    path = tmp_path / "hostile.safetensors"
    path.write_bytes(_hostile(_good())[case])
    with pytest.raises(FileError, match=r"hostile\.safetensors") as caught:
        weights.read(path)
    assert "\n" not in str(caught.value)


def test_missing_files_and_folders_are_named(tmp_path):
    with pytest.raises(FileError, match=r"no weights file '.*absent"):
        weights.read(tmp_path / "absent.safetensors")
    with pytest.raises(FileError, match="weights file"):
        weights.read(tmp_path)


def test_unwritable_output_is_named(tmp_path):
    with pytest.raises(FileError, match="cannot write"):
        weights.save(tmp_path / "absent" / "w.safetensors", ARCH, init(ARCH, 0), {})


def test_missing_default_weights_name_the_cure(monkeypatch, tmp_path):
    monkeypatch.setattr(weights, "SHIPPED", tmp_path)
    with pytest.raises(FileError, match="install the package again"):
        weights.shipped.__wrapped__(weights.DEFAULT)


def test_shipped_weights_are_small_and_say_where_they_come_from():
    model = weights.find("default")
    assert model is weights.default_model() is weights.find(None)
    assert (weights.SHIPPED / "default.safetensors").stat().st_size < 2_000_000
    assert {"seed", "data", "metrics", "cost", "versions"} <= set(model.header)


def test_unknown_names_name_the_shipped_weights():
    with pytest.raises(FileError, match="no weights 'large'; give a file, or 'default'"):
        weights.find("large")


def test_a_file_is_read_once_until_it_changes(tmp_path):
    path = tmp_path / "own.safetensors"
    weights.save(path, ARCH, init(ARCH, 0), {})
    first = weights.find(path)
    assert weights.find(str(path)) is first
    weights.save(path, ARCH, init(ARCH, 1), {})
    assert weights.find(path).fingerprint != first.fingerprint
