"""Stores: pure shards, resumption to the same bytes, and one error sentence for each mistake."""

import dataclasses
import hashlib
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from urushi import files
from urushi.errors import FileError, ParameterError
from urushi.fan2022 import store as generation
from urushi.fan2022.store import DataSpec, Part, Store, generate, make_shard
from urushi.train.distribution import Extended
from urushi.walk import analytic

pytestmark = pytest.mark.slow  # only the training of Fan et al. has stores

SPEC = DataSpec(
    parts=(
        Part("coated", Extended(), stacks=10, pairs=16, walks=4),
        Part("twice", Extended(2, "diffuse"), stacks=3, pairs=16, walks=2),
        Part("bare", Extended(0, "conductor_complex"), stacks=5, pairs=16, walks=1),
    ),
    seed=3,
    shard=4,
)


def fingerprints(path):
    """The hash of each file of a store, by name."""
    return {
        str(file.relative_to(path)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in path.rglob("*")
        if file.is_file()
    }


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "whole"
    generate(SPEC, path)
    return path


def test_a_store_holds_what_was_specified(finished):
    store = Store(finished, SPEC)
    assert store.missing() == []
    for part in SPEC.parts:
        arrays = store.read(part)
        assert arrays["f"].shape == arrays["se"].shape == (part.stacks, part.pairs)
        assert arrays["wi"].shape == arrays["wo"].shape == (part.stacks, part.pairs, 3)
        assert arrays["f"].min() >= 0
    assert store.read(SPEC.parts[1])["coats"].shape == (3, 2, 5)


def test_bottoms_without_a_coat_are_exact(finished):
    part = SPEC.parts[2]
    arrays = Store(finished, SPEC).read(part)
    assert "coats" not in arrays
    columns = dict(zip(("alpha", "eta", "k"), arrays["bottom"].T, strict=True))
    row = np.repeat(np.arange(part.stacks, dtype=np.uint32), part.pairs)
    wi, wo = (arrays[name].reshape(-1, 3) for name in ("wi", "wo"))
    f = analytic.rows("conductor_complex", columns, row, wi, wo)
    np.testing.assert_array_equal(arrays["f"].ravel(), f)
    assert (arrays["se"] == 0).all()


def test_shards_do_not_depend_on_the_order_in_which_they_are_made(finished):
    store = Store(finished, SPEC)  # made first to last
    for index in reversed(list(SPEC.shards())):
        again, stored = make_shard(SPEC, *index), store.read_shard(*index)
        for name in again:
            np.testing.assert_array_equal(again[name], stored[name])


def test_stacks_of_different_shards_differ(finished):
    coats = Store(finished, SPEC).read(SPEC.parts[0])["coats"]
    assert len(np.unique(coats[:, 0, 0])) == 10


def test_a_generator_that_fails_midway_resumes_to_the_same_bytes(finished, tmp_path, monkeypatch):
    path = tmp_path / "resumed"
    made = []

    def interrupted(spec, part, shard):
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append((part, shard))
        return make_shard(spec, part, shard)

    monkeypatch.setattr(generation, "make_shard", interrupted)
    with pytest.raises(KeyboardInterrupt):
        generate(SPEC, path)
    assert len(Store(path, SPEC).missing()) == 4
    with pytest.raises(FileError, match="incomplete: part 'coated' has 2 of 3 shards"):
        Store(path, SPEC).read(SPEC.parts[0])
    monkeypatch.undo()
    generate(SPEC, path)
    assert fingerprints(path) == fingerprints(finished)


def test_a_lost_shard_is_simulated_again(finished, tmp_path):
    path = tmp_path / "torn"
    generate(SPEC, path)
    (path / "coated" / "00001.safetensors").unlink()
    (path / "coated" / ".00001-x7f3.safetensors").write_bytes(b"of a killed writer")
    assert Store(path, SPEC).missing() == [(0, 1)]
    generate(SPEC, path)
    assert fingerprints(path) == fingerprints(finished)


def test_a_truncated_shard_is_simulated_again(finished, tmp_path):
    """As a copy that was interrupted leaves it."""
    path = tmp_path / "short"
    generate(SPEC, path)
    shard = path / "coated" / "00001.safetensors"
    for size in (shard.stat().st_size - 1, 20, 0):
        shard.write_bytes(shard.read_bytes()[:size])
        assert Store(path, SPEC).missing() == [(0, 1)]
    generate(SPEC, path)
    assert fingerprints(path) == fingerprints(finished)


def test_a_killed_process_resumes_to_the_same_bytes(tmp_path):
    spec = DataSpec(
        parts=(Part("coated", Extended(), stacks=64, pairs=81, walks=50),), seed=1, shard=2
    )
    script = (
        "import sys\n"
        "from urushi.train.distribution import Extended\n"
        "from urushi.fan2022.store import DataSpec, Part, generate\n"
        "part = Part('coated', Extended(), stacks=64, pairs=81, walks=50)\n"
        "generate(DataSpec((part,), seed=1, shard=2), sys.argv[1])\n"
    )
    path = tmp_path / "killed"
    command = [sys.executable, "-c", script, str(path)]
    process = subprocess.Popen(command)
    deadline = time.monotonic() + 60
    while not any(path.glob("coated/0*")) and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert 0 < len(Store(path, spec).missing()) < 32
    generate(spec, path)
    generate(spec, tmp_path / "whole")
    assert fingerprints(path) == fingerprints(tmp_path / "whole")


def test_the_hash_depends_on_specification_and_values(finished, tmp_path):
    expected = Store(finished, SPEC).hash()
    assert generate(SPEC, tmp_path / "again").hash() == expected
    other = generate(dataclasses.replace(SPEC, seed=4), tmp_path / "other")
    assert other.hash() != expected
    shutil.copytree(finished, tmp_path / "changed")
    store = Store(tmp_path / "changed", SPEC)
    arrays = store.read_shard(0, 1)
    arrays["f"][3, 3] *= 1.001
    store.write(0, 1, arrays)
    assert store.hash() != expected


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": 5}, r"another specification \(its seed is 3, not 5\)"),
        ({"parts": SPEC.parts[:1]}, "its parts are coated, twice, bare instead of coated"),
        (
            {"parts": (dataclasses.replace(SPEC.parts[0], walks=8), *SPEC.parts[1:])},
            "its part 'coated' has another specification",
        ),
    ],
)
def test_another_specification_is_refused(finished, change, message):
    with pytest.raises(FileError, match=message):
        generate(dataclasses.replace(SPEC, **change), finished)


def test_foreign_folders_and_files_are_refused_and_left_alone(tmp_path):
    folder = tmp_path / "photos"
    folder.mkdir()
    (folder / "cat.jpg").write_bytes(b"meow")
    file = tmp_path / "file"
    file.write_text("text")
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "store.json").write_text("[]")
    for path in (folder, file, tmp_path / "foreign"):
        with pytest.raises(FileError, match="is not a data store of Urushi"):
            generate(SPEC, path)
    assert (folder / "cat.jpg").read_bytes() == b"meow"


def test_a_newer_format_is_refused(tmp_path):
    store = generate(DataSpec(parts=SPEC.parts[2:]), tmp_path / "new")
    manifest = store.path / "store.json"
    manifest.write_text(manifest.read_text().replace('"format_version": 2', '"format_version": 99'))
    with pytest.raises(FileError, match="data format 99, and this Urushi reads 2"):
        generate(store.spec, store.path)


def test_a_damaged_shard_is_reported(tmp_path):
    store = generate(DataSpec(parts=SPEC.parts[2:]), tmp_path / "damaged")
    whole = store.read_shard(0, 0)
    shard = store.path / "bare" / "00000.safetensors"
    shard.write_bytes(shard.read_bytes()[:-10])
    with pytest.raises(FileError, match="is not a valid data file or is truncated"):
        store.read(store.spec.parts[0])
    whole["f"][0, 0] = np.nan
    files.write_tensors(shard, "data", {}, whole)
    with pytest.raises(FileError, match="values that are not finite; delete it and resume"):
        store.read(store.spec.parts[0])


def test_an_unwritable_place_is_reported(tmp_path):
    (tmp_path / "file").write_text("text")
    with pytest.raises(FileError, match=r"cannot create the folder .* choose one that is writable"):
        generate(SPEC, tmp_path / "file" / "store")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Part("a", Extended(), 0, 1, 1),
            "part 'a' has stacks = 0; give a positive integer",
        ),
        (lambda: Part("a", Extended(), 1, 1, 1, "sphere"), "directions = 'sphere'; choose"),
        (lambda: Part("a", Extended(), 1, 8, 1), "8 stratified pairs; give a fourth power"),
        (lambda: DataSpec((SPEC.parts[0], SPEC.parts[0])), "two parts .* have the same name"),
    ],
)
def test_bad_specifications_get_one_sentence(make, message):
    with pytest.raises(ParameterError, match=message):
        make()
