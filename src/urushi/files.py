"""Files: atomic writing, folders, and Urushi's own format.

Urushi's files are safetensors files with named arrays and one JSON description.
"""

import contextlib
import json
import os
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy

from urushi.errors import FileError, ParameterError

#: The only metadata key. Several keys would be written in a different order from run to run.
METADATA_KEY = "urushi"

#: The suffix of the files. They may have none.
SUFFIX = ".safetensors"

#: Temporary files of writers at work.
_temporary_files: set[Path] = set()


def remove_temporary_files() -> None:
    """Remove what writers have begun, before the process ends without their doing."""
    for path in tuple(_temporary_files):
        path.unlink(missing_ok=True)


def as_path(path: Any) -> Path:
    """The path of a file; a ParameterError if it is neither text nor a path, or has a null."""
    try:
        result = Path(path)
        if "\0" in str(result):
            raise TypeError(path)
    except TypeError as error:
        raise ParameterError(f"path must be the path of a file, not {path!r}") from error
    return result


def is_file(path: str | os.PathLike) -> bool:
    """Whether a path is that of a file; no if the name is too long, or the folder is private."""
    try:
        return Path(path).is_file()
    except OSError:
        return False


def check_file(path: Path, otherwise: str) -> None:
    """Raise FileError unless a path is that of a file that can be read.

    otherwise: the error's sentence, unless permissions are what is missing.
    """
    try:
        if stat.S_ISREG(path.stat().st_mode):
            with path.open("rb"):
                return
    except PermissionError as error:
        raise FileError(
            f"cannot read '{path}': {error.strerror}; check the path and its permissions"
        ) from error
    except OSError:
        pass
    raise FileError(otherwise)


@contextlib.contextmanager
def atomic_write(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary path in the folder of `path`; rename it to `path` on success.

    Readers see either the old file or the whole new one. The temporary path has the same suffix.
    On any exception the temporary file is removed and `path` is unchanged. Links are followed.

    Raises:
        FileError: the folder is missing or cannot be written, the disk is full, or `path` is a
            folder or a device.
    """
    target, temporary = as_path(path), None
    try:
        place = target.resolve()
        if place.exists() and not place.is_file():  # renaming would replace a device
            raise FileError(f"cannot write '{target}': it is not a file; choose another name")
        handle, name = tempfile.mkstemp(dir=place.parent, prefix=".urushi-", suffix=target.suffix)
        os.close(handle)
        temporary = Path(name)
        _temporary_files.add(temporary)
        yield temporary
        os.umask(mask := os.umask(0))  # the mask can be read only by setting it
        temporary.chmod(0o666 & ~mask)  # mkstemp makes private files
        temporary.replace(place)
    except FileError:
        raise
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        cure = "free some space or choose another folder"
        if temporary is None:  # RuntimeError: links in a circle
            cure = "choose a folder that exists and is writable"
        elif isinstance(error, RuntimeError):
            # Mitsuba's streams: "... I/O error while ...: No space left on device".
            if "I/O error" not in reason:
                raise
            reason = reason.rpartition(": ")[2]
        raise FileError(f"cannot write '{target}': {reason}; {cure}") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
            _temporary_files.discard(temporary)


def new_folder(path: str | os.PathLike) -> Path:
    """Make a folder and its parents, unless it exists.

    Raises:
        FileError: it cannot be made, or is a file.
    """
    folder = as_path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = f"{error.strerror or error}; choose one that is writable"
        if isinstance(error, FileExistsError):
            reason = "it is a file; choose another name"
        raise FileError(f"cannot create the folder '{folder}': {reason}") from error
    return folder


def check_name(path: str | os.PathLike) -> None:
    """Refuse a name for `write_tensors` that ends in another suffix than `SUFFIX`."""
    if as_path(path).suffix not in ("", SUFFIX):
        raise ParameterError(f"'{path}' does not end in {SUFFIX}; give a file's name that does")


def write_tensors(
    path: str | os.PathLike, kind: str, description: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
    """Write arrays and a description (JSON values) as a file of a kind, for example "weights".

    Raises:
        ParameterError: `path` is no path, or ends in another suffix than `SUFFIX`.
        FileError: the file cannot be written.
    """
    check_name(path)
    text = json.dumps({"kind": kind, **description}, sort_keys=True)
    content = safetensors.numpy.save(
        {name: np.ascontiguousarray(array) for name, array in arrays.items()}, {METADATA_KEY: text}
    )
    with atomic_write(path) as temporary:
        temporary.write_bytes(content)


def read_tensors(
    path: str | os.PathLike,
    kind: str,
    version: int | None = None,
    names: Collection[str] | None = None,
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the description and the arrays of a file that `write_tensors` wrote.

    version: the only one that can be read, the entry `version` of the description; None: any.
    names: of the arrays to read, in this order, where the file has them; None: all.

    Raises:
        FileError: the file is missing, unreadable, truncated, foreign, or of another kind or
            version.
    """
    source = as_path(path)
    try:
        size = source.stat().st_size
        if source.is_dir():
            raise FileError(f"'{source}' is a folder; give a {kind} file")
        source.open("rb").close()  # a library's error for a private file is that of a missing one
        with safetensors.safe_open(source, framework="numpy") as file:
            metadata = file.metadata() or {}
            stored = list(file.keys())
            wanted = stored if names is None else [name for name in names if name in stored]
            arrays = {name: file.get_tensor(name) for name in wanted}
    except FileNotFoundError as error:
        raise FileError(f"there is no {kind} file '{source}'; check the path") from error
    except FileError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise FileError(
            f"cannot read the {kind} file '{source}': {reason}; check the path and its permissions"
        ) from error
    except (safetensors.SafetensorError, AttributeError, TypeError, ValueError) as error:
        raise FileError(
            f"'{source}' ({size} bytes) is not a valid {kind} file or is truncated ({error}); "
            "copy or write it again"
        ) from error
    description = _description(metadata.get(METADATA_KEY, ""))
    if description.get("kind") != kind:
        raise FileError(
            f"'{source}' is a safetensors file, but not one of Urushi's {kind.removesuffix('s')}s"
        )
    if version is not None and description.get("version") != version:
        raise FileError(
            f"'{source}' has version {description.get('version')!r} of the {kind} format, "
            f"this Urushi reads version {version}; install the Urushi that wrote it"
        )
    return description, arrays


#: What NumPy raises for files that are no archives of arrays; MemoryError: they claim to be huge.
NO_ARCHIVE = (
    *(OSError, ValueError, EOFError, TypeError, MemoryError),
    *(zipfile.BadZipFile, zlib.error),
)


def read_npz(path: str | os.PathLike, *names: str) -> list[np.ndarray]:
    """Arrays of a file of `numpy.savez`.

    Raises:
        FileError: the file is missing, damaged, of another kind or without one of the arrays.
    """
    source = as_path(path)
    try:
        # opened here, because numpy does not close a file that it cannot read
        with source.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        if not all(isinstance(array, np.ndarray) for array in arrays.values()):
            raise ValueError(path)
    except NO_ARCHIVE as error:
        reason = "it is not an NPZ file; write it with numpy.savez"
        if strerror := getattr(error, "strerror", None):
            reason = f"{strerror}; check the path and its permissions"
        raise FileError(f"cannot read '{source}': {reason}") from error
    for name in names:
        if name not in arrays:
            wanted = f"array{'s' * (len(names) > 1)} {' and '.join(names)}"
            raise FileError(f"'{source}' must hold the {wanted}; it has no {name}")
    return [arrays[name] for name in names]


def tensor_file_kind(path: str | os.PathLike) -> str | None:
    """The kind of a file that `write_tensors` wrote; None for any other or a missing file."""
    try:
        with safetensors.safe_open(path, framework="numpy") as file:
            return _description((file.metadata() or {}).get(METADATA_KEY, "")).get("kind")
    except (OSError, safetensors.SafetensorError, AttributeError, TypeError, ValueError):
        return None


def _description(text: str) -> dict[str, Any]:
    """The JSON object in a file's metadata; empty if there is none."""
    try:
        description = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return description if isinstance(description, dict) else {}
