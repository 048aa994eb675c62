"""State dicts in files of `torch.save`, read with NumPy alone and without running anything in them.

The content of a file is a pickle, a program that may call what it names. Here each name stands for
something harmless, such as the description of a tensor's place, and every other name is refused.

The authors saved the bound method `state_dict` of a network, so that their scripts call the result
of `torch.load`. It stands for the tensors of the network's modules, as a whole network does.
Modules, and objects of classes in the authors' `model.py` and `utils.py`, are read as their
attributes.
"""

import io
import math
import os
import pickle
import zipfile
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided

from urushi.errors import FileError

#: First bytes of the format that PyTorch wrote before version 1.6, and the version of the format.
_LEGACY, _LEGACY_VERSION = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.", 1001

#: NumPy's names of the little-endian types of storages.
STORAGES = {"HalfStorage": "<f2", "FloatStorage": "<f4", "DoubleStorage": "<f8"}

#: Modules of the classes that a pickle may name: PyTorch's layers, and the authors' scripts.
CLASS_MODULES = ("model", "utils", "torch.nn.modules.")

#: Largest number of values of a tensor: sixteen times as many as the paper's largest tensor has.
MAX_VALUES = 1 << 22

CURE = "give a file of torch.save(network.state_dict())"


class Storage(NamedTuple):
    """A row of numbers in the file; dtype: NumPy's name of the type."""

    dtype: str
    key: str
    length: int


class Tensor(NamedTuple):
    """A tensor's place in a storage, unchecked; offset and strides count numbers, not bytes."""

    storage: Storage
    offset: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]


def state_dict(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """The float tensors that a file holds, float32 by name.

    The file holds a dictionary of tensors, a checkpoint with one among its entries, a network, or
    its method `state_dict`; in the zip format, or in that of PyTorch before 1.6 (2020).

    Raises:
        FileError: it is missing or damaged, or holds or names something else.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileError(f"cannot read '{path}': {error.strerror}; check the path") from error
    if not data.startswith((_LEGACY, b"PK")):
        raise FileError(f"'{path}' is not a PyTorch file; give one written by torch.save")
    try:
        content, numbers = (_read_legacy if data.startswith(_LEGACY) else _read_zip)(data)
    except FileError as error:
        raise FileError(f"'{path}' {error}") from None
    except Exception as error:  # a damaged pickle raises many kinds
        raise FileError(
            f"'{path}' is damaged, or has more than tensors in dictionaries; {CURE}"
        ) from error
    entries = content.values() if isinstance(content, dict) else ()
    found = [value for value in (content, *entries) if _holds_tensors(value)]
    if len(found) != 1:
        raise FileError(
            f"'{path}' should hold one state dict and holds {len(found) or 'none'}; {CURE}"
        )
    return {
        name: _array(tensor, numbers, f"the tensor '{name}' of '{path}'")
        for name, tensor in found[0].items()
    }


def _holds_tensors(value: Any) -> bool:
    """Whether a value is a dictionary of tensors by name."""
    return (
        isinstance(value, dict)
        and len(value) > 0
        and all(isinstance(k, str) and isinstance(v, Tensor) for k, v in value.items())
    )


def _array(tensor: Tensor, numbers: Mapping[str, bytes], where: str) -> np.ndarray:
    """The values of a tensor; where: begins errors."""
    storage, offset, shape, strides = tensor
    try:
        whole = np.frombuffer(numbers[storage.key], storage.dtype)
        last = offset + sum((n - 1) * s for n, s in zip(shape, strides, strict=True))
        if min(offset, *shape, *strides) < 0 or math.prod(shape) > MAX_VALUES:
            raise ValueError(shape)
        if len(whole) != storage.length or last >= len(whole):
            raise ValueError(last)
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(f"{where} lies outside its storage; download or save it again") from error
    steps = [step * whole.itemsize for step in strides]
    with np.errstate(over="ignore"):  # of doubles: refused below
        array = np.array(as_strided(whole[offset:], shape, steps, writeable=False), np.float32)
    if not np.isfinite(array).all():
        raise FileError(
            f"{where} holds a number that is not finite in single precision; give other weights"
        )
    return array


def _read_zip(data: bytes) -> tuple[Any, dict[str, bytes]]:
    """Content of a zip file, and the numbers of its storages by key."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("/data.pkl"))
        folder = f"{name.removesuffix('.pkl')}/"
        files = [file for file in archive.namelist() if file.startswith(folder)]
        if sum(archive.getinfo(file).file_size for file in (name, *files)) > len(data):
            raise ValueError(name)  # PyTorch does not compress: the numbers could fill any memory
        numbers = {file.removeprefix(folder): archive.read(file) for file in files}
        return _Unpickler(io.BytesIO(archive.read(name))).content(), numbers


def _read_legacy(data: bytes) -> tuple[Any, dict[str, bytes]]:
    """As `_read_zip`, of the older format.

    Five pickles follow each other: a number, the format's version, the machine, the content, and
    the keys of its storages. After them, each storage has its length, 8 bytes, and its values.
    """
    file = io.BytesIO(data)
    _, version, _machine = (_Unpickler(file).content() for _ in range(3))
    reader = _Unpickler(file)
    content, keys = reader.content(), _Unpickler(file).content()
    found, place = {}, file.tell()
    for key in keys:
        storage = reader.storages[key]
        end = place + 8 + storage.length * np.dtype(storage.dtype).itemsize
        found[key] = data[place + 8 : end]
        if int.from_bytes(data[place : place + 8], "little") != storage.length or end > len(data):
            raise ValueError(key)
        place = end
    if version != _LEGACY_VERSION:
        raise ValueError(version)
    return content, found


class _Unpickler(pickle.Unpickler):
    """The reader of one pickle. What names stand for belongs to it: a pickle may change it."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file)
        self.storages: dict[str, Storage] = {}
        self.Object = type("Object", (), {})

    def content(self) -> Any:
        """The value that the pickle describes; of a network, its tensors by name.

        Raises:
            FileError: the pickle names another object.
            Exception: of any kind; it is damaged.
        """
        value = self.load()
        return _tensors_of(value) if type(value) is self.Object else value

    def find_class(self, module: str, name: str) -> Any:
        match module.replace("__builtin__", "builtins"), name:
            case "collections", "OrderedDict":
                return OrderedDict
            case ("torch", "Size") | ("builtins", "set"):  # sets of names, in newer modules
                return tuple
            case "builtins", "getattr":
                return lambda network, method: {"state_dict": _tensors_of}[method](network)
            case "torch._utils", "_rebuild_tensor_v2":
                return lambda *arguments: _tensor(*arguments[:4])
            case "torch._utils", "_rebuild_parameter":
                return lambda tensor, *_: tensor
            case "torch.nn.backends.thnn", "_get_thnn_function_backend":  # until PyTorch 1.4
                return lambda: None
            case "torch", kind if kind in STORAGES:
                return STORAGES[kind]
        place = module if "." not in module else module[: module.rindex(".") + 1]
        if place in CLASS_MODULES and name.isidentifier():
            return self.Object
        raise FileError(
            f"names the Python object '{module}.{name}', and only dictionaries of float tensors "
            f"are read; nothing was run; {CURE}"
        )

    def persistent_load(self, identity: Any) -> Any:
        """A storage: ("storage", type, key, device, length), and None for no view in old files.

        Old files have the class of a module like this: ("module", class, its file, its text).
        """
        if identity[0] == "module":
            return identity[1]
        word, kind, key, _, length, *view = identity
        if word != "storage" or kind not in STORAGES.values() or view not in ([], [None]):
            raise ValueError(word)
        return self.storages.setdefault(key, Storage(kind, key, length))


def _tensor(storage: Any, offset: Any, shape: Any, strides: Any) -> Tensor:
    """The description of a tensor, whose numbers must be whole ones."""
    if type(storage) is not Storage or any(type(n) is not int for n in (offset, *shape, *strides)):
        raise TypeError(storage)
    return Tensor(storage, offset, tuple(shape), tuple(strides))


def _tensors_of(network: Any) -> dict[str, Tensor]:
    """The tensors of a module and of all modules within, by name, as PyTorch's `state_dict` does.

    No module may occur twice: a short pickle could contain one module exponentially often.
    """
    tensors: dict[str, Tensor] = {}
    found: set[int] = set()
    waiting = [("", network)]
    while waiting:
        prefix, module = waiting.pop()
        if id(module) in found:
            raise ValueError(prefix)
        found.add(id(module))
        own = vars(module)
        for name, tensor in (own["_parameters"] | own["_buffers"]).items():
            if tensor is not None:
                tensors[f"{prefix}{name}"] = tensor
        waiting += [(f"{prefix}{n}.", part) for n, part in own["_modules"].items()][::-1]
    return tensors
