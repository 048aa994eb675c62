"""Writing files so that a reader sees either the whole new file or the old one; and folders."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from urushi.errors import FileError


@contextlib.contextmanager
def atomic_write(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path beside `path`, of the same suffix; rename it to `path` on success.

    On any exception the temporary file is removed and `path` is left as it was.

    Raises:
        FileError: the folder is missing or cannot be written, or the disk is full.
    """
    target = Path(path)
    try:
        handle, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix
        )
        os.close(handle)
    except OSError as error:
        raise FileError(
            f"cannot write '{target}': {error.strerror or error}; "
            "choose a folder that exists and is writable"
        ) from error
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())  # mkstemp makes private files
        temporary.replace(target)
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(
            f"cannot write '{target}': {error.strerror or error}; "
            "free some space or choose another folder"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def new_folder(path: str | os.PathLike) -> Path:
    """Make a folder and those above it, unless it is there.

    Raises:
        FileError: it cannot be made, or is a file.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"cannot make the folder '{folder}': {error.strerror or error}; "
            "choose one that is writable"
        ) from error
    return folder


def _umask() -> int:
    """The process's file mode mask (readable only by setting it)."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
