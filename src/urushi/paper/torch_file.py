"""Files of `torch.save`, read with NumPy alone."""

import math
import os
import zipfile
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided

from urushi.errors import FileError
from urushi.paper.pickled import Tensor, decode

#: Largest file, and largest pickle in it. The paper's networks have 12 MB, their pickles 30 kB.
MAX_FILE, MAX_PICKLE = 1 << 26, 1 << 20

#: Largest number of values of a tensor: sixteen times that of the paper's largest.
MAX_VALUES = 1 << 22

#: First bytes of the format that PyTorch wrote before version 1.6.
_LEGACY = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19."


class TorchFile:
    """An open file of `torch.save`; a context manager.

    Only the zip format is read, which is PyTorch's since version 1.6 (2020). Members are not
    compressed there, so that memory is bounded by the file's size.

    Attributes:
        path: the file.
        content: dicts, lists, tuples, numbers, text, None and tensors, see `pickled.decode`.
    """

    def __init__(self, path: str | os.PathLike) -> None:
        """Open a file and read its pickle; the tensors' values are read by `array`.

        Raises:
            FileError: the file is missing, too large, truncated, foreign, of the older format, or
                holds anything but tensors in dictionaries.
        """
        self.path = Path(path)
        self._archive = _opened(self.path)
        try:
            names = [n for n in self._archive.namelist() if n.endswith("/data.pkl")]
            if len(names) != 1:
                raise FileError(
                    f"'{path}' is a zip file, but not one of torch.save; "
                    "give a file of torch.save(network.state_dict())"
                )
            self._folder = names[0].removesuffix("data.pkl")
            order = f"{self._folder}byteorder"
            if order in self._archive.namelist() and self._member(order, 16) != b"little":
                raise FileError(
                    f"'{path}' has big-endian numbers; save it again on a little-endian machine"
                )
            self.content: Any = decode(self._member(names[0], MAX_PICKLE), path)
        except BaseException:
            self._archive.close()
            raise

    def __enter__(self) -> "TorchFile":
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._archive.close()

    def array(self, tensor: Tensor, name: str) -> np.ndarray:
        """The values of a tensor as a new float32 array; name: for errors.

        Raises:
            FileError: the tensor is too large or lies outside its storage, its storage is missing
                or damaged, or a value is not finite.
        """
        storage, path = tensor.storage, self.path
        shape, strides = tensor.shape, tensor.strides
        if len(shape) != len(strides) or min((tensor.offset, *shape, *strides), default=0) < 0:
            raise FileError(f"the tensor '{name}' of '{path}' has a wrong shape; save it again")
        if math.prod(shape) > MAX_VALUES:
            raise FileError(
                f"the tensor '{name}' of '{path}' has shape {shape}; the paper's networks have at "
                f"most {MAX_VALUES} values in one"
            )
        last = tensor.offset + sum((n - 1) * s for n, s in zip(shape, strides, strict=True))
        if 0 not in shape and last >= storage.length:
            raise FileError(
                f"the tensor '{name}' of '{path}' lies outside its storage; save it again"
            )
        dtype = np.dtype(storage.dtype)
        data = self._member(f"{self._folder}data/{storage.key}", MAX_FILE)
        if len(data) != storage.length * dtype.itemsize:
            raise FileError(
                f"the storage of the tensor '{name}' of '{path}' has {len(data)} bytes instead of "
                f"{storage.length * dtype.itemsize}; download or save the file again"
            )
        values = np.frombuffer(data, dtype)[tensor.offset :]
        steps = tuple(s * dtype.itemsize for s in strides)
        view = as_strided(values, shape, steps, writeable=False)
        with np.errstate(over="ignore"):  # of doubles: refused below
            array = np.array(view, np.float32, order="C")
        if not np.isfinite(array).all():
            raise FileError(
                f"the tensor '{name}' of '{path}' holds a number that is not finite in single "
                "precision; give other weights"
            )
        return array

    def _member(self, name: str, most: int) -> bytes:
        """The bytes of a member, at most `most`."""
        try:
            member = self._archive.getinfo(name)
            if member.compress_type != zipfile.ZIP_STORED:
                raise FileError(
                    f"'{self.path}' is compressed, but torch.save never compresses; save it again"
                )
            if member.file_size > most:
                raise FileError(
                    f"'{name}' in '{self.path}' has {member.file_size} bytes, more than {most}; "
                    "give a file of torch.save(network.state_dict())"
                )
            return self._archive.read(member)
        except KeyError as error:
            raise FileError(
                f"'{self.path}' lacks the values '{name}'; download or save it again"
            ) from error
        except FileError:
            raise
        except (OSError, EOFError, RuntimeError, zipfile.BadZipFile) as error:
            raise _damaged(self.path) from error


def _opened(path: Path) -> zipfile.ZipFile:
    """The file as a zip archive."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            first = file.read(len(_LEGACY))
    except OSError as error:
        raise FileError(
            f"cannot read '{path}': {error.strerror or error}; check the path"
        ) from error
    if size > MAX_FILE:
        raise FileError(
            f"'{path}' has {size} bytes, and files of the paper's networks at most {MAX_FILE}; "
            "give a file of torch.save(network.state_dict())"
        )
    if first == _LEGACY:
        raise FileError(
            f"'{path}' has the format that PyTorch wrote before version 1.6; "
            'write it again by a newer one: torch.save(torch.load(FILE, map_location="cpu"), FILE)'
        )
    if not first.startswith(b"PK"):
        raise FileError(f"'{path}' is not a PyTorch file; give one written by torch.save")
    try:
        return zipfile.ZipFile(path)
    except (OSError, RuntimeError, ValueError, zipfile.BadZipFile) as error:
        raise _damaged(path) from error


def _damaged(path: Path) -> FileError:
    return FileError(f"'{path}' is truncated or damaged; download or save it again")
