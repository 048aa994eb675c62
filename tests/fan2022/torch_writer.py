"""Files in the layouts of torch.save, written without PyTorch."""

import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

STORAGES = {"<f2": "HalfStorage", "<f4": "FloatStorage", "<f8": "DoubleStorage"}

PROTO, STOP = b"\x80\x02", b"."


def text(value: str) -> bytes:
    data = value.encode()
    return b"X" + struct.pack("<I", len(data)) + data


def integer(value: int) -> bytes:
    return b"J" + struct.pack("<i", value)


def named(module: str, name: str) -> bytes:
    return f"c{module}\n{name}\n".encode()


def integers(values) -> bytes:
    return b"(" + b"".join(map(integer, values)) + b"t"


EMPTY = named("collections", "OrderedDict") + b")R"


def tensor(array: np.ndarray, key: str, *, parameter=False, shape=None, strides=None, offset=0):
    """Instructions for a tensor whose storage has the array's values."""
    kind = named("torch", STORAGES[array.dtype.str])
    shape = array.shape if shape is None else shape
    if strides is None:
        strides = [int(np.prod(shape[i + 1 :])) for i in range(len(shape))]
    storage = b"(" + text("storage") + kind + text(key) + text("cpu") + integer(array.size) + b"tQ"
    place = integer(offset) + integers(shape) + integers(strides)
    rebuilt = named("torch._utils", "_rebuild_tensor_v2")
    rebuilt += b"(" + storage + place + b"\x89" + EMPTY + b"tR"
    whole = named("torch._utils", "_rebuild_parameter") + b"(" + rebuilt + b"\x88" + EMPTY + b"tR"
    return whole if parameter else rebuilt


def dictionary(entries: Mapping[str, bytes]) -> bytes:
    """An OrderedDict with the state `_metadata`, as of state_dict()."""
    items = b"".join(text(name) + value for name, value in entries.items())
    metadata = b"}" + text("_metadata") + EMPTY + b"s"
    return EMPTY + b"(" + items + b"u" + metadata + b"b"


def state_dict(tensors: Mapping[str, np.ndarray], **options) -> tuple[bytes, dict[str, bytes]]:
    """Instructions of a state dict, and its storages by key."""
    entries = {n: tensor(a, str(i), **options) for i, (n, a) in enumerate(tensors.items())}
    return dictionary(entries), {str(i): a.tobytes() for i, a in enumerate(tensors.values())}


def write(path: Path, program: bytes, storages: Mapping[str, bytes]) -> Path:
    """Write instructions and storages as a zip file."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"{path.stem}/data.pkl", PROTO + program + STOP)
        for key, data in storages.items():
            archive.writestr(f"{path.stem}/data/{key}", data)
        archive.writestr(f"{path.stem}/version", b"3\n")
    return path
