"""Urushi's own files: named arrays and one JSON description in the safetensors format."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy

from urushi.errors import FileError
from urushi.files import atomic_write

#: The metadata's only key: one key keeps the bytes of a file the same from run to run.
KEY = "urushi"


def write(
    path: str | os.PathLike, kind: str, description: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
    """Write arrays and a description (JSON values) as a file of a kind such as "weights".

    Raises:
        FileError: the file cannot be written.
    """
    text = json.dumps({"kind": kind, **description}, sort_keys=True)
    content = safetensors.numpy.save(
        {name: np.ascontiguousarray(array) for name, array in arrays.items()}, {KEY: text}
    )
    with atomic_write(path) as temporary:
        temporary.write_bytes(content)


def read(path: str | os.PathLike, kind: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the description and the arrays of a file that `write` made.

    Raises:
        FileError: the file is missing, unreadable, truncated, foreign or of another kind.
    """
    source = Path(path)
    try:
        size = source.stat().st_size
        with safetensors.safe_open(source, framework="numpy") as file:
            metadata = file.metadata() or {}
            names = file.keys()
            arrays = {name: file.get_tensor(name) for name in names}
    except FileNotFoundError as error:
        raise FileError(f"there is no {kind} file '{source}'; check the path") from error
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"cannot read the {kind} file '{source}': {reason}") from error
    except (safetensors.SafetensorError, AttributeError, TypeError, ValueError) as error:
        raise FileError(
            f"'{source}' ({size} bytes) is no {kind} file or is truncated ({error}); "
            "copy or create it again"
        ) from error
    description = _description(metadata.get(KEY, ""))
    if description.get("kind") != kind:
        raise FileError(f"'{source}' is a safetensors file, but not one of Urushi's {kind}s")
    return description, arrays


def kind_of(path: str | os.PathLike) -> str | None:
    """The kind of a file that `write` made; None: it is no such file, or is not there."""
    try:
        with safetensors.safe_open(path, framework="numpy") as file:
            return _description((file.metadata() or {}).get(KEY, "")).get("kind")
    except (OSError, safetensors.SafetensorError, AttributeError, TypeError, ValueError):
        return None


def _description(text: str) -> dict[str, Any]:
    try:
        description = json.loads(text)
    except ValueError:
        return {}
    return description if isinstance(description, dict) else {}
