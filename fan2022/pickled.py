"""The pickle in a file of `torch.save`, read without running anything that it names.

A pickle is a program for a stack machine. Here it may use only the instructions that tensors in
dictionaries need, and each name stands for something harmless: a tensor becomes a description of
where its values are, and every other name is refused.

The authors saved the bound method `state_dict` of a network, so that their scripts call the result
of `torch.load`. It stands for the tensors of the network's modules, as a whole network does.
Modules, and objects of classes in the authors' `model.py` and `utils.py`, are read as their
attributes.
"""

import io
import pickle
import pickletools
from collections import OrderedDict
from typing import Any, NamedTuple

from urushi.errors import FileError

#: The instructions that are read.
INSTRUCTIONS = frozenset(
    """
    PROTO FRAME STOP NONE NEWTRUE NEWFALSE BININT BININT1 BININT2 LONG1 BINFLOAT BINUNICODE
    SHORT_BINUNICODE EMPTY_DICT EMPTY_LIST EMPTY_TUPLE MARK TUPLE TUPLE1 TUPLE2 TUPLE3 APPEND
    APPENDS SETITEM SETITEMS BINPUT LONG_BINPUT MEMOIZE BINGET LONG_BINGET GLOBAL STACK_GLOBAL
    NEWOBJ REDUCE BUILD BINPERSID
    """.split()  # noqa: SIM905
)

#: Most tuples of a pickle; a tensor has five. Hashing deeply nested ones would end the process.
MAX_TUPLES = 10_000

#: NumPy's names of the types of storages.
STORAGES = {"HalfStorage": "<f2", "FloatStorage": "<f4", "DoubleStorage": "<f8"}

#: Modules of the classes that a pickle may name: PyTorch's layers, and the authors' scripts.
CLASS_MODULES = ("model", "utils", "torch.nn.modules.")


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


def decode(file: io.BytesIO) -> tuple[Any, dict[str, Storage]]:
    """Return the value that a pickle describes, and its storages by key.

    Values are dicts, lists, tuples, numbers, text, None and tensors. Reading ends after the last
    instruction.

    Raises:
        FileError: the pickle names another object.
        Exception: of any kind; it has other instructions, or is damaged.
    """
    start = file.tell()
    tuples = 0
    for count, (code, argument, _) in enumerate(pickletools.genops(file)):
        tuples += code.name.startswith("TUPLE")
        if code.name not in INSTRUCTIONS:
            raise ValueError(f"{code.name} is not needed for tensors in dictionaries")
        if (
            code.name == "LONG_BINPUT" and int(argument or 0) > count
        ):  # Python would reserve as many places
            raise ValueError("a place in the memo is too high")
        if tuples > MAX_TUPLES:
            raise ValueError("there are too many tuples")
    size = file.tell() - start
    file.seek(start)
    reader = _Unpickler(io.BytesIO(file.read(size)))
    value = reader.load()
    return state_dict(value) if type(value) is reader.Object else value, reader.storages


class _Unpickler(pickle.Unpickler):
    """The reader of one pickle. What names stand for belongs to it: a pickle may change it."""

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file)
        self.storages: dict[str, Storage] = {}
        self.Object = type("Object", (), {})

    def find_class(self, module: str, name: str) -> Any:
        match module.replace("__builtin__", "builtins"), name:
            case "collections", "OrderedDict":
                return OrderedDict
            case ("torch", "Size") | ("builtins", "set"):  # sets of names, in newer modules
                return tuple
            case "builtins", "getattr":
                return lambda network, method: {"state_dict": state_dict}[method](network)
            case "torch._utils", "_rebuild_tensor_v2":
                return lambda *arguments: tensor(*arguments[:4])
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
            "are read; nothing was run; give a file of torch.save(network.state_dict())"
        )

    def persistent_load(self, identity: Any) -> Any:
        """A storage: ("storage", type, key, device, length), and None for no view in old files.

        Old files have the class of a module like this: ("module", class, its file, its text).
        """
        if identity[0] == "module":
            return identity[1]
        word, kind, key, _, length, *view = identity
        if word != "storage" or view not in ([], [None]):
            raise ValueError(word)
        storage = Storage(kind, key, length)
        if self.storages.setdefault(key, storage) != storage:
            raise ValueError(key)
        return storage


def tensor(storage: Any, offset: Any, shape: Any, strides: Any) -> Tensor:
    """The description of a tensor, whose numbers must be whole ones."""
    if type(storage) is not Storage or any(type(n) is not int for n in (offset, *shape, *strides)):
        raise TypeError(storage)
    return Tensor(storage, offset, tuple(shape), tuple(strides))


def state_dict(network: Any) -> dict[str, Tensor]:
    """The tensors of a module and of all modules within, by name, as PyTorch's method does.

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
