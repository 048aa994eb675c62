"""Measured BRDFs, MERL tables and RGL materials, and measured paints."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.files import as_path, tensor_file_kind
from urushi.measured import merl, rgl_file
from urushi.measured.merl import Merl
from urushi.measured.pigments import pigment
from urushi.measured.rgl import Rgl

__all__ = ["Merl", "Rgl", "load_measured", "pigment"]


def load_measured(path: str | os.PathLike) -> Merl | Rgl:
    """Read a measured BRDF. The file's contents, not its name, determine the format.

    Args:
        path: a MERL table (Matusik et al. 2003, `.binary`) or an RGL material, RGB or spectral,
            isotropic or anisotropic (Dupuy and Jakob 2018, `.bsdf`).

    Returns:
        An object whose f(wi, wo) -> (N, 3) is linear RGB [1/sr] without cosine.

    Raises:
        FileError: the file is missing, unreadable, damaged or of another format.
        ParameterError: `path` is not a path.
    """
    source = as_path(path)
    surface: Any
    content: Any
    try:
        with source.open("rb") as file:
            start = file.read(512)
        if start.startswith(rgl_file.MAGIC):
            surface, content = Rgl, rgl_file.read(source)
        elif start.startswith(merl.HEADER):
            surface, content = Merl, merl.read(source)
        else:
            raise _foreign(source, start)
    except FileNotFoundError as error:
        raise FileError(f"there is no file '{source}'; check the path") from error
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"cannot read '{source}': {error.strerror or error}") from error
    try:
        return surface(content)
    except FileError as error:
        raise FileError(f"cannot use '{source}': {error}") from error


def _foreign(source: Path, start: bytes) -> FileError:
    """The error for a file of another format; it says what the file resembles."""
    text = start.lstrip().lower()
    if text.startswith(b"<?xml"):
        return FileError(
            f"'{source}' is an XML file, not a BRDF; a BSDF of a scene is SCENE.xml#ID, and "
            "urushi convert reads MaterialX"
        )
    if text.startswith((b"<!doctype", b"<html", b"<head")):
        return FileError(f"'{source}' is a web page, not a BRDF; download the file itself")
    if kind := tensor_file_kind(source):
        return FileError(
            f"'{source}' is a {kind} file of Urushi, not a measured BRDF; urushi layer coats "
            "materials, and urushi.load reads them"
        )
    size = source.stat().st_size
    resembles = size == merl.FILE_SIZE or start[:8] == merl.HEADER[:8]
    if resembles and len(start) >= len(merl.HEADER):
        found = " x ".join(map(str, np.frombuffer(start[: len(merl.HEADER)], "<i4")))
        return FileError(f"'{source}' has dimensions {found}; a MERL table has 90 x 90 x 180")
    return FileError(
        f"'{source}' ({size} bytes) is neither a MERL table "
        "(it does not start with the dimensions 90, 90, 180) nor an RGL tensor file; "
        "check that it was downloaded whole"
    )
