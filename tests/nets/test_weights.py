"""Weights files: a round trip, a fingerprint that means something, and hostile files."""

import json

import numpy as np
import pytest
import safetensors.numpy
from tests.fuzzing import fuzz
from tests.untrained import untrained

from urushi.errors import FileError, ParameterError
from urushi.files import read_tensors, write_tensors
from urushi.nets import weights
from urushi.nets.networks import Architecture

SIZES = {"functions": 3, "layerer": (8,), "probes": 16}
ARCH = Architecture(**SIZES)
NOT_FINITE = np.full(ARCH.parameter_shapes()["basis.rows"], np.inf, np.float32)


def init(seed: int = 0) -> dict[str, np.ndarray]:
    """Random parameters, which can be changed."""
    return {name: x.copy() for name, x in untrained(seed, **SIZES).params.items()}


def content(params=None, **metadata) -> bytes:
    """A file with parameters and this metadata."""
    return safetensors.numpy.save(params or {"a": np.zeros(3, np.float32)}, metadata)


def described(**changes) -> str:
    """The metadata of weights with changes."""
    arch = json.loads(ARCH.to_json())
    return json.dumps({"kind": "weights", "version": 1, "architecture": arch} | changes)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "weights.safetensors"
    return path, weights.save(path, ARCH, init(), {"preset": "quick", "seed": 0})


def test_round_trip(saved, tmp_path):
    path, model = saved
    again = weights.read(path)
    assert again.arch == ARCH and again.header == {"preset": "quick", "seed": 0}
    assert again.fingerprint == model.fingerprint
    assert all(np.array_equal(again.params[name], model.params[name]) for name in model.params)
    other = tmp_path / "again.safetensors"
    weights.save(other, ARCH, init(), {"seed": 0, "preset": "quick"})
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
    params = init()
    model = weights.Model.of(ARCH, params, {})
    params["layerer.0.weight"][:] = 7
    assert not (model.params["layerer.0.weight"] == 7).any()
    with pytest.raises(ValueError, match="read-only"):
        model.params["layerer.0.weight"][0, 0] = 1


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("layerer.1.bias", None, "is missing"),
        ("extra", np.zeros(1, np.float32), "is unknown"),
        ("layerer.0.bias", np.zeros(9, np.float32), "has shape"),
        ("layerer.0.bias", np.full(8, np.nan, np.float32), "holds a number that is not finite"),
        ("basis.rows", NOT_FINITE, "holds a number that is not finite"),
    ],
)
def test_broken_parameters_are_refused(name, value, words, tmp_path):
    params = {n: x for n, x in (init() | {name: value}).items() if x is not None}
    with pytest.raises(ParameterError, match=f"'{name}' {words}"):
        weights.Model.of(ARCH, params, {})
    path = tmp_path / "broken.safetensors"
    path.write_bytes(content(params, urushi=described()))
    with pytest.raises(FileError, match=f"'{name}' {words}"):
        weights.read(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "not one of Urushi's weight"),
        ("{", "not one of Urushi's weight"),
        ("[1]", "not one of Urushi's weight"),
        ("[" * 100_000, "not one of Urushi's weight"),
        (described(kind="material"), "not one of Urushi's weight"),
        (described(version=9), "has version 9 .* reads version 1"),
        (described(architecture=None), "is damaged"),
        (described(architecture={"probes": 1e9}), "architecture's probes is 1000000000"),
        (described(architecture={"azimuthal": [1]}), r"azimuthal is \(1,\); it must be at most 0"),
        (described(architecture={"widths": 2, "azimuthal": ["a"]}), "azimuthal is "),
        (described(architecture={"widths": 2, "azimuthal": [32]}), "azimuthal is "),
        (described(architecture={"kind": "paper"}), "'paper', but those of 'urushi' are"),
    ],
)
def test_other_descriptions_are_refused(text, words, tmp_path):
    path = tmp_path / "other.safetensors"
    path.write_bytes(content(init(), **({"format": "pt"} if text is None else {"urushi": text})))
    with pytest.raises(FileError, match=rf"other\.safetensors.*{words}"):
        weights.read(path)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("basis.grid", np.full((2, 4), np.nan), "'basis.rows' holds a number that is not finite"),
        ("basis.grid", np.full((2, 4), 1e300), "'basis.rows' holds a number that is not finite"),
        ("basis.grid", np.ones((2, 4), np.complex64), "complex numbers"),
        ("basis.rows", None, "'basis.rows' is missing"),
    ],
)
def test_damaged_rows_of_a_basis_are_refused(saved, name, value, words):
    """Also in files, which hold them in fixed point."""
    path, _ = saved
    description, arrays = read_tensors(path, "weights")
    arrays = {n: x for n, x in (arrays | {name: value}).items() if x is not None}
    del description["kind"]
    write_tensors(path, "weights", description, arrays)
    with pytest.raises(FileError, match=f"is damaged: .*{words}"):
        weights.read(path)


def test_mutants_are_refused_in_one_sentence(saved, tmp_path):
    html = b"<!DOCTYPE html><html><body>404 Not Found</body></html>" * 20
    seeds = [saved[0].read_bytes(), b"", html, content(), saved[0].read_bytes() + b"more"]
    assert fuzz(weights.read, tmp_path / "mutant", seeds, 100, memory=1 << 23) < 60


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda path: weights.read(path / "absent.safetensors"), "no weights file '.*absent"),
        (lambda path: weights.read(path), "weights file"),
        (lambda path: weights.save(path / "a" / "w", ARCH, init(), {}), "cannot write"),
        (lambda _: weights.find("large"), "no weights 'large'; give a file, or 'default'"),
        (lambda path: weights.find(path), "no weights '.*'; give a file"),
        (lambda path: weights.find("x" * 300), "no weights 'xxx"),
    ],
)
def test_missing_files_and_folders_are_named(call, sentence, tmp_path):
    with pytest.raises(FileError, match=sentence):
        call(tmp_path)


def test_missing_default_weights_name_the_cure(monkeypatch, tmp_path):
    monkeypatch.setattr(weights, "SHIPPED", tmp_path)
    with pytest.raises(FileError, match="install the package again"):
        weights.shipped.__wrapped__(weights.DEFAULT)


def test_shipped_weights_are_small_and_say_where_they_come_from():
    model = weights.find("default")
    assert model is weights.default_model() is weights.find(None)
    assert (weights.SHIPPED / "default.safetensors").stat().st_size < 2_500_000
    assert {"seed", "data", "metrics", "cost", "versions"} <= set(model.header)


def test_a_file_is_read_once_until_it_changes(saved):
    path, _ = saved
    first = weights.find(path)
    assert weights.find(str(path)) is first
    weights.save(path, ARCH, init(1), {})
    assert weights.find(path).fingerprint != first.fingerprint
