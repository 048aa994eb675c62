"""The pickle in a file of `torch.save`, read without running anything that it names.

A pickle is a program for a stack machine, and Python's own reader calls whatever it names. The
reader of this module knows the instructions that tensors in dictionaries need, and gives each name
a stand-in: a tensor becomes a description of where its values are. Every other name is refused.
Time and memory are proportional to the pickle's length.

The authors saved the bound method `state_dict` of a network, so that their scripts call
the result of `torch.load`. It stands for the tensors of the network's modules, as a whole network
does. Modules, and objects of classes in the authors' `model.py` and `utils.py`, are read as their
attributes.
"""

import os
import pickle
import struct
from collections.abc import Callable
from typing import Any, BinaryIO, ClassVar, NamedTuple

from urushi.errors import FileError


class Storage(NamedTuple):
    """A row of numbers in the file; dtype: NumPy's name of the little-endian type."""

    dtype: str
    key: str
    length: int


class Tensor(NamedTuple):
    """A tensor's place in a storage, unchecked; offset and strides count numbers, not bytes."""

    storage: Storage
    offset: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]


class _Object:
    """An object of a class that is not imported: it has the attributes alone."""


def decode(file: BinaryIO, path: str | os.PathLike) -> tuple[Any, dict[str, Storage]]:
    """Return the value that a pickle describes, and its storages by key.

    Values are dicts, lists, tuples, numbers, text, None and tensors. Reading ends after the last
    instruction. path: of the file, for errors.
    """
    reader = _Unpickler(file)
    try:
        value = reader.load()
        is_network = isinstance(value, _Object)
        return _state_dict(value, "state_dict") if is_network else value, reader.storages
    except FileError as error:
        raise FileError(f"'{path}' {error}") from None
    except (
        *(AttributeError, EOFError, IndexError, KeyError, MemoryError, TypeError, ValueError),
        *(pickle.UnpicklingError, struct.error),
    ) as error:
        raise FileError(
            f"'{path}' is damaged, or its pickle has instructions that tensors in dictionaries do "
            "not need; give a file of torch.save(network.state_dict())"
        ) from error


def _tensor(storage: Any, offset: Any, shape: Any, strides: Any, *_: Any) -> Tensor:
    return Tensor(_of(storage, Storage), _of(offset, int), _integers(shape), _integers(strides))


def _empty_dictionary() -> dict[str, Any]:
    return {}  # `dict` would take entries, whose keys could be anything


def _state_dict(network: Any, method: Any) -> dict[str, Tensor]:
    """The tensors of a module and of all modules within, by name, as PyTorch's method does.

    No module may occur twice: a short pickle could contain one module exponentially often.
    """
    if method != "state_dict":
        raise ValueError(method)
    tensors: dict[str, Tensor] = {}
    found: set[_Object] = set()
    waiting = [("", _of(network, _Object))]
    while waiting:
        prefix, module = waiting.pop()
        if module in found:
            raise ValueError(prefix)
        found.add(module)
        for kind in ("_parameters", "_buffers"):
            for name, tensor in _of(vars(module)[kind], dict).items():
                if tensor is not None:
                    tensors[f"{prefix}{name}"] = _of(tensor, Tensor)
        inner = _of(vars(module)["_modules"], dict).items()
        waiting += [(f"{prefix}{name}.", _of(part, _Object)) for name, part in inner][::-1]
    return tensors


#: Stand-ins of all that a pickle may name, besides classes of `CLASS_MODULES`.
STANDINS: dict[tuple[str, str], Callable | str] = {
    ("collections", "OrderedDict"): _empty_dictionary,
    ("__builtin__", "getattr"): _state_dict,
    ("builtins", "getattr"): _state_dict,
    ("__builtin__", "set"): lambda _: None,  # of names, in modules of newer versions
    ("builtins", "set"): lambda _: None,
    ("torch", "Size"): lambda sizes: sizes,
    ("torch._utils", "_rebuild_tensor_v2"): _tensor,
    ("torch._utils", "_rebuild_parameter"): lambda tensor, *_: _of(tensor, Tensor),
    ("torch.nn.backends.thnn", "_get_thnn_function_backend"): lambda: None,  # until PyTorch 1.4
    ("torch", "HalfStorage"): "<f2",
    ("torch", "FloatStorage"): "<f4",
    ("torch", "DoubleStorage"): "<f8",
}

#: Modules of the classes that a pickle may name: PyTorch's layers, and the authors' scripts.
CLASS_MODULES = ("model", "utils", "torch.nn.modules.")


#: Python's reader in Python. That in C makes room for every place in its memo, up to 2^32.
_Reader: Any = pickle._Unpickler

#: The instructions that are read, by their codes in `pickle`.
_INSTRUCTIONS = b"\x80\x95.N\x88\x89JKM\x8aGX\x8c()}]t\x85\x86\x87aebsuq\x72\x94hjc\x93\x81QR"


class _Unpickler(_Reader):
    """The reader of one pickle."""

    dispatch: ClassVar = {code: _Reader.dispatch[code] for code in _INSTRUCTIONS}

    def __init__(self, file: BinaryIO) -> None:
        super().__init__(file)
        self.storages: dict[str, Storage] = {}

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in STANDINS:
            return STANDINS[module, name]
        place = module if "." not in module else module[: module.rindex(".") + 1]
        if place in CLASS_MODULES and name.isidentifier():
            return _Object
        if not name:  # the file ends here
            raise EOFError
        raise FileError(
            f"names the Python object '{module}.{name}', and only dictionaries of float tensors "
            "are read; nothing was run; give a file of torch.save(network.state_dict())"
        )

    def persistent_load(self, identity: Any) -> Any:
        """A storage: ("storage", type, key, device, length), and None for no view in old files.

        Old files have the class of a module like this: ("module", class, its file, its text).
        """
        word, kind, key, _, *rest = _of(identity, tuple)
        if word == "module" and kind is _Object:
            return kind
        if word != "storage" or rest[1:] not in ([], [None]):
            raise ValueError(word)
        storage = Storage(_of(kind, str), _of(key, str), _of(rest[0], int))
        if self.storages.setdefault(key, storage) != storage:
            raise ValueError(key)
        return storage

    def _build(self) -> None:
        """Set attributes, but not of functions. A state dict has some that are not needed."""
        attributes, target = _of(self.stack.pop(), dict), self.stack[-1]
        if isinstance(target, _Object):
            vars(target).update(attributes)
        else:
            _of(target, dict)

    def _set(self, entries: list[Any]) -> None:
        """Set keys, which are text or numbers: hashes of nested tuples could take for ever."""
        target = _of(self.stack[-1], dict)
        for key, value in zip(entries[::2], entries[1::2], strict=True):
            if type(key) not in (str, int):
                raise TypeError(key)
            target[key] = value

    dispatch[pickle.BUILD[0]] = _build
    dispatch[pickle.SETITEM[0]] = lambda self: self._set([self.stack.pop(-2), self.stack.pop()])
    dispatch[pickle.SETITEMS[0]] = lambda self: self._set(self.pop_mark())


def _of(value: Any, kind: type) -> Any:
    """The value, which must have exactly this type: a bool is no int."""
    if type(value) is not kind:
        raise TypeError(kind)
    return value


def _integers(values: Any) -> tuple[int, ...]:
    return tuple(_of(value, int) for value in _of(values, tuple))
