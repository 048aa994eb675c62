"""A reader finds the whole new file or the old one, even if the writing is interrupted."""

import errno
import io
import os
import re
import stat
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest

from urushi.errors import FileError, ParameterError
from urushi.files import (
    atomic_write,
    check_file,
    is_file,
    new_folder,
    read_npz,
    read_tensors,
    write_tensors,
)


def test_writes_the_whole_file(tmp_path):
    """With the mode of an ordinary one."""
    target, ordinary = tmp_path / "new.txt", tmp_path / "ordinary"
    ordinary.touch()
    with atomic_write(target) as temporary:
        assert temporary.parent == tmp_path and temporary.suffix == ".txt"
        temporary.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert set(os.listdir(tmp_path)) == {"new.txt", "ordinary"}
    assert stat.S_IMODE(target.stat().st_mode) == stat.S_IMODE(ordinary.stat().st_mode)


def test_the_longest_name_of_a_file_can_be_written(tmp_path):
    target = tmp_path / f"{'x' * 250}.text"
    with atomic_write(target) as temporary:
        temporary.write_text("whole")
    assert is_file(target) and not is_file(f"{target}more")


FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
#: As of Mitsuba's streams.
STREAM = RuntimeError(
    '[FileStream] "a": I/O error while attempting to write 8192 bytes: No space left on device'
)


@pytest.mark.parametrize(
    "failure", [RuntimeError("bug"), KeyboardInterrupt(), FileError("why"), FULL, STREAM]
)
def test_a_failure_keeps_the_old_file(tmp_path, failure):
    """Where the disk is full, the sentence keeps the reason and names the file."""
    target, full = tmp_path / "old", failure in (FULL, STREAM)
    target.write_text("old")
    with pytest.raises(FileError if full else type(failure)) as caught:
        with atomic_write(target) as temporary:
            temporary.write_text("half of the n")
            raise failure
    if full:
        sentence = f"cannot write '{target}': No space left on device; free some space"
        assert str(caught.value).startswith(sentence)
    else:
        assert caught.value is failure
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["old"]


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="file': it is a file; choose another name"):
        new_folder(tmp_path / "file")


@pytest.mark.parametrize("name", ["nowhere/file", "file/below", "folder", "circle"])
def test_places_that_cannot_be_written(tmp_path, name):
    """A parent that is a file stands for every folder that cannot be written, root's too."""
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "circle").symlink_to(tmp_path / "circle")
    before = set(os.listdir(tmp_path))
    with pytest.raises(FileError, match="cannot write .*; choose") as caught:
        with atomic_write(tmp_path / name):
            pytest.fail("there is no place for a file")
    assert isinstance(caught.value, OSError)
    assert set(os.listdir(tmp_path)) == before


def test_a_device_stays_a_device(tmp_path):
    """A pipe stands for devices such as /dev/null, which renaming would replace by a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(FileError, match="pipe': it is not a file; choose"), atomic_write(pipe):
        pass
    assert pipe.is_fifo() and os.listdir(tmp_path) == ["pipe"]


def test_links_are_followed(tmp_path):
    (tmp_path / "disk").mkdir()
    link = tmp_path / "link.txt"
    link.symlink_to(tmp_path / "disk" / "text")
    for text in ("new", "newer"):
        with atomic_write(link) as temporary:
            assert temporary.suffix == ".txt"
            temporary.write_text(text)
        assert link.is_symlink() and (tmp_path / "disk" / "text").read_text() == text


@pytest.mark.parametrize("path", [None, 3, "a\0b"])
def test_what_is_no_path_is_refused(path):
    for use in (
        lambda: read_tensors(path, "material"),
        lambda: write_tensors(path, "material", {}, {}),
    ):
        with pytest.raises(
            ParameterError, match=re.escape(f"path must be the path of a file, not {path!r}")
        ):
            use()


def test_folders_and_other_suffixes_are_refused(tmp_path):
    with pytest.raises(FileError, match="is a folder; give a material file"):
        read_tensors(tmp_path, "material")
    with pytest.raises(ParameterError, match=r"x.txt' does not end in .safetensors"):
        write_tensors(tmp_path / "x.txt", "material", {}, {})
    assert not list(tmp_path.iterdir())


@pytest.fixture
def other_user():
    """Without the permissions of root."""
    user = os.geteuid()
    os.seteuid(user or 65534)
    yield
    os.seteuid(user)


@pytest.mark.parametrize("private", ["file", "folder"])
def test_what_may_not_be_read_is_not_called_missing(private, other_user):
    with tempfile.TemporaryDirectory() as folder:
        path, place = Path(folder, "private.safetensors"), Path(folder)
        write_tensors(path, "weights", {}, {"a": np.zeros(1)})
        (path if private == "file" else place).chmod(0)
        for read in (
            lambda: check_file(path, "missing"),
            lambda: read_tensors(path, "weights"),
            lambda: read_npz(path, "a"),
        ):
            with pytest.raises(FileError, match="cannot read .*private.*: Permission denied; ch"):
                read()
        place.chmod(0o700)


def test_archives_of_other_content_are_refused(tmp_path):
    """One that claims a huge array before memory is taken for it, which no machine has."""
    path, header = tmp_path / "pairs.npz", io.BytesIO()

    def refused(sentence=r"it is not an NPZ file; write it with numpy\.savez"):
        with pytest.raises(FileError, match=sentence):
            read_npz(path, "wi", "wo")

    path.write_text("no archive")
    refused()
    np.savez(path, wi=np.zeros((1, 3)))
    refused("must hold the arrays wi and wo")
    np.savez(path, wi=np.array([{}], dtype=object), wo=np.zeros((1, 3)))  # would need pickle
    refused()
    path.write_bytes(path.read_bytes()[:100])
    refused()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (1 << 50, 3)}
    np.lib.format.write_array_header_1_0(header, shape)
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("wi", "wo"):
            archive.writestr(f"{name}.npy", header.getvalue())
    refused()
