"""The file format of the RGL database: named arrays in one little-endian "tensor_file".

char[12] "tensor_file\\0", uint8 version[2], uint32 number of fields; then for each field uint16
length of the name, the name, uint16 number of dimensions, uint8 type, uint64 offset of the data
from the start of the file, uint64 shape[].
"""

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from urushi.errors import FileError

MAGIC = b"tensor_file\0"
VERSION = (1, 0)

#: Limits; files of the database have 11 fields of up to 5 dimensions.
MAX_FIELDS, MAX_DIMENSIONS = 256, 16

#: NumPy types by their codes in the file.
TYPES = {
    1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8",
    9: "<f2", 10: "<f4", 11: "<f8",
}  # fmt: skip


@dataclass(frozen=True)
class _Field:
    """A tensor's entry in the header; `start` and `end` are byte offsets in the file."""

    name: str
    dtype: np.dtype
    shape: tuple[int, ...]
    start: int
    end: int


def read(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays by name.

    Sizes are checked against the size of the file before memory is allocated, so that all arrays
    together are never larger than the file.

    Raises:
        FileError: the file is no tensor file, of another version or truncated, or its tensors
            repeat a name, overlap, or lie outside of the file.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        reader = _Reader(file, path, size)
        if reader.take(len(MAGIC)) != MAGIC:
            raise FileError(f"'{path}' is not a tensor file; its first bytes are not 'tensor_file'")
        version = reader.unpack("BB")
        if version != VERSION:
            raise FileError(
                f"the tensor file '{path}' has version {version[0]}.{version[1]}; "
                "only 1.0 can be read"
            )
        (count,) = reader.unpack("I")
        if count > MAX_FIELDS:
            raise reader.damaged(f"it claims {count} fields")
        fields = [_field(reader) for _ in range(count)]
        _check_places(fields, file.tell(), reader)
        return {field.name: _array(file, field, reader) for field in fields}


class _Reader:
    """Reads the header; raises a FileError at the end of the file."""

    def __init__(self, file: BinaryIO, path: Path, size: int) -> None:
        self.file, self.path, self.size = file, path, size

    def take(self, count: int) -> bytes:
        content = self.file.read(count)
        if len(content) < count:
            raise self.damaged("its header is truncated")
        return content

    def unpack(self, layout: str) -> tuple[int, ...]:
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def damaged(self, what: str) -> FileError:
        return FileError(
            f"the tensor file '{self.path}' ({self.size} bytes) is damaged: {what}; obtain it again"
        )


def _field(reader: _Reader) -> _Field:
    """Read one tensor's entry in the header."""
    (length,) = reader.unpack("H")
    name = reader.take(length).decode("utf-8", "replace")[:40]
    dimensions, code, start = reader.unpack("HBQ")
    if code not in TYPES:
        raise reader.damaged(f"its tensor {name!r} has the unknown type {code}")
    if dimensions > MAX_DIMENSIONS:
        raise reader.damaged(f"its tensor {name!r} claims {dimensions} dimensions")
    shape = reader.unpack(f"{dimensions}Q")
    dtype = np.dtype(TYPES[code])
    return _Field(name, dtype, shape, start, start + math.prod(shape) * dtype.itemsize)


def _check_places(fields: list[_Field], header_end: int, reader: _Reader) -> None:
    """Raise a FileError if tensors repeat a name, overlap, or lie outside of the file."""
    if len({field.name for field in fields}) < len(fields):
        raise reader.damaged("two of its tensors have the same name")
    end, previous = header_end, "the header"
    for field in sorted(fields, key=lambda field: (field.start, field.end)):
        if field.end > reader.size:
            raise reader.damaged(
                f"its tensor {field.name!r} ends at byte {field.end}, outside the file"
            )
        if field.start < end:
            raise reader.damaged(f"its tensor {field.name!r} overlaps {previous}")
        end, previous = field.end, repr(field.name)


def _array(file: BinaryIO, field: _Field, reader: _Reader) -> np.ndarray:
    """Read one tensor's data."""
    file.seek(field.start)
    data = np.fromfile(file, field.dtype, math.prod(field.shape))
    if data.nbytes < field.end - field.start:
        raise reader.damaged(f"its tensor {field.name!r} is truncated")
    try:
        return data.reshape(field.shape)
    except ValueError as error:  # a dimension too large for NumPy in an empty array
        raise reader.damaged(f"its tensor {field.name!r} has the shape {field.shape}") from error
