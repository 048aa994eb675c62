"""The file format of the RGL database: named arrays in one little-endian "tensor_file".

char[12] "tensor_file\\0", uint8 version[2], uint32 number of fields; then for each field uint16
length of the name, the name, uint16 number of dimensions, uint8 type, uint64 offset of the data
from the start of the file, uint64 shape[].
"""

import math
import struct
from pathlib import Path

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


def read(path: Path) -> dict[str, np.ndarray]:
    """The arrays by name of a file that begins with `MAGIC`; they share the memory of its content.

    Raises:
        FileError: the file is of another version or truncated, or its tensors repeat a name,
            overlap, or lie outside of it.
    """
    content = path.read_bytes()
    if tuple(content[12:14]) not in ((), VERSION):
        version = ".".join(map(str, content[12:14]))
        raise FileError(f"the tensor file '{path}' has version {version}; only 1.0 can be read")
    try:
        return _tensors(content)
    except (struct.error, ValueError) as error:
        what = "its header is truncated" if isinstance(error, struct.error) else error
        raise FileError(
            f"the tensor file '{path}' ({len(content)} bytes) is damaged: {what}; obtain it again"
        ) from error


def _tensors(content: bytes) -> dict[str, np.ndarray]:
    """The arrays; a ValueError says what is wrong with them."""
    place = len(MAGIC) + len(VERSION)

    def unpack(layout: str) -> tuple:
        nonlocal place
        values = struct.unpack_from("<" + layout, content, place)
        place += struct.calcsize("<" + layout)
        return values

    (count,) = unpack("I")
    if count > MAX_FIELDS:
        raise ValueError(f"it claims {count} fields")
    found, extents = {}, []
    for _ in range(count):
        (length,) = unpack("H")
        name = unpack(f"{length}s")[0].decode("utf-8", "replace")[:40]
        dimensions, code, start = unpack("HBQ")
        if code not in TYPES:
            raise ValueError(f"its tensor {name!r} has the unknown type {code}")
        if dimensions > MAX_DIMENSIONS:
            raise ValueError(f"its tensor {name!r} claims {dimensions} dimensions")
        shape, dtype = unpack(f"{dimensions}Q"), np.dtype(TYPES[code])
        end = start + math.prod(shape) * dtype.itemsize
        if end > len(content):
            raise ValueError(f"its tensor {name!r} ends at byte {end}, outside the file")
        if name in found:
            raise ValueError(f"two of its tensors have the name {name!r}")
        try:
            found[name] = np.frombuffer(memoryview(content)[start:end], dtype).reshape(shape)
        except ValueError as error:  # a dimension too large for NumPy in an empty array
            raise ValueError(f"its tensor {name!r} has the shape {shape}") from error
        extents.append((start, end, repr(name)))
    end, previous = place, "the header"
    for start, following, name in sorted(extents):
        if start < end:
            raise ValueError(f"its tensor {name} overlaps {previous}")
        end, previous = following, name
    return found
