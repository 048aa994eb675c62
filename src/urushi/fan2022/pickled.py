"""The pickle in a file of `torch.save`, read without running anything that it names.

A pickle is a program for a stack machine, and Python's own `pickle` calls whatever it names. This
module interprets the few instructions that tensors in dictionaries need. It has no calls: a tensor
becomes a description of where its values are, and every other object is refused by its name. Time
and memory are proportional to the pickle's length.

The authors saved the bound method `state_dict` of a network, so that their scripts call
the result of `torch.load`. It stands for the tensors of the network's modules. Modules, and objects
of classes in the authors' `model.py` and `utils.py`, are read as their attributes.
"""

import os
import pickletools
from dataclasses import dataclass, field
from typing import Any, BinaryIO, NamedTuple, NoReturn

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


class _Global(NamedTuple):
    """An object that the pickle names."""

    module: str
    name: str


@dataclass(frozen=True, eq=False)
class _Object:
    """An object of a class that is not imported: its attributes by name."""

    attributes: dict[str, Any] = field(default_factory=dict)


_DICTIONARY = _Global("collections", "OrderedDict")
_METHOD = _Global("__builtin__", "getattr")
_SIZE = _Global("torch", "Size")
_TENSOR = _Global("torch._utils", "_rebuild_tensor_v2")
_PARAMETER = _Global("torch._utils", "_rebuild_parameter")
_DTYPES = {
    _Global("torch", "HalfStorage"): "<f2",
    _Global("torch", "FloatStorage"): "<f4",
    _Global("torch", "DoubleStorage"): "<f8",
}

#: All functions and types that a pickle may name. None of them is imported.
ALLOWED = frozenset({_DICTIONARY, _METHOD, _SIZE, _TENSOR, _PARAMETER, *_DTYPES})

#: Modules of the classes that a pickle may name: PyTorch's, and the authors' scripts.
CLASS_MODULES = frozenset(
    ["model", "utils"]
    + [f"torch.nn.modules.{k}" for k in ("activation", "container", "linear", "normalization")]
)

_MARK = object()

#: Classes of empty values, and constants, by instruction.
_EMPTY = {"EMPTY_DICT": dict, "EMPTY_LIST": list, "EMPTY_TUPLE": tuple}
_CONSTANTS = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False, "MARK": _MARK}


def decode(file: BinaryIO, path: str | os.PathLike) -> tuple[Any, dict[str, Storage]]:
    """Return the value that a pickle describes, and its storages by key.

    Values are dicts, lists, tuples, numbers, text, None and tensors. Reading ends after the last
    instruction. path: of the file, for errors.
    """
    machine = _Machine(path)
    try:
        return machine.run(file), machine.storages
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise FileError(
            f"'{path}' is damaged: its pickle is no sequence of instructions that PyTorch writes; "
            "download or save it again"
        ) from error


class _Machine:
    """The stack, and the memo of objects that are used again."""

    def __init__(self, path: str | os.PathLike) -> None:
        self._path = path
        self._stack: list[Any] = []
        self._memo: dict[int, Any] = {}
        self.storages: dict[str, Storage] = {}

    def run(self, file: BinaryIO) -> Any:
        for instruction, argument, _ in pickletools.genops(file):
            self._step(instruction.name, argument)
        (result,) = self._stack
        return result

    def _step(self, instruction: str, argument: Any) -> None:
        stack, memo = self._stack, self._memo
        match instruction:
            case "BININT" | "BININT1" | "BININT2" | "LONG1" | "BINFLOAT":
                stack.append(argument)
            case "BINUNICODE" | "SHORT_BINUNICODE":
                stack.append(argument)
            case _ if instruction in _CONSTANTS:
                stack.append(_CONSTANTS[instruction])
            case _ if instruction in _EMPTY:
                stack.append(_EMPTY[instruction]())
            case "TUPLE":
                stack.append(tuple(self._since_mark()))
            case "TUPLE1" | "TUPLE2" | "TUPLE3":
                values = [stack.pop() for _ in range(int(instruction[-1]))]
                stack.append(tuple(values[::-1]))
            case "APPEND" | "APPENDS":
                values = [stack.pop()] if instruction == "APPEND" else self._since_mark()
                _of(stack[-1], list).extend(values)
            case "SETITEM" | "SETITEMS":
                pair = instruction == "SETITEM"
                values = [stack.pop(-2), stack.pop()] if pair else self._since_mark()
                for key, value in zip(values[::2], values[1::2], strict=True):
                    _set(stack[-1], key, value)
            case "BINPUT" | "LONG_BINPUT":
                memo[argument] = stack[-1]
            case "MEMOIZE":
                memo[len(memo)] = stack[-1]
            case "BINGET" | "LONG_BINGET":
                stack.append(memo[argument])
            case "GLOBAL" | "INST":
                stack.append(self._named(*str(argument).split(" ", 1)))
            case "STACK_GLOBAL":
                name, module = stack.pop(), stack.pop()
                stack.append(self._named(_of(module, str), _of(name, str)))
            case "NEWOBJ":
                arguments, kind = stack.pop(), _of(stack.pop(), _Global)
                if kind.module not in CLASS_MODULES or arguments != ():
                    raise ValueError(kind)
                stack.append(_Object())
            case "BUILD":  # attributes; a state dict has versions of modules, which are not needed
                attributes, target = stack.pop(), stack[-1]
                if isinstance(target, _Object):
                    target.attributes.update(_of(attributes, dict))
                else:
                    _of(target, dict)
            case "BINPERSID":
                stack.append(self._persistent(*_of(stack.pop(), tuple)))
            case "REDUCE":
                arguments, function = stack.pop(), stack.pop()
                stack.append(self._called(function, _of(arguments, tuple)))
            case "PROTO":
                if not 2 <= argument <= 4:
                    raise ValueError(argument)
            case "FRAME" | "STOP":  # frames help to read ahead only
                pass
            case _:
                raise FileError(
                    f"'{self._path}' uses the pickle's instruction {instruction}, which tensors in "
                    "dictionaries do not need; give a file of torch.save(network.state_dict())"
                )

    def _since_mark(self) -> list[Any]:
        """Pop everything above the last mark, and the mark."""
        values = []
        while (value := self._stack.pop()) is not _MARK:
            values.append(value)
        return values[::-1]

    def _named(self, module: str, name: str) -> _Global:
        is_class = module in CLASS_MODULES and name.isidentifier()
        if (module, name) not in ALLOWED and not is_class:
            self._refuse(f"{module}.{name}")
        return _Global(module, name)

    def _refuse(self, name: str) -> NoReturn:
        raise FileError(
            f"'{self._path}' names the Python object '{name}', and only dictionaries of float "
            "tensors are read; nothing was run; give a file of torch.save(network.state_dict())"
        )

    def _persistent(self, word: Any, kind: Any, key: Any, device: Any, *rest: Any) -> Any:
        """A storage: ("storage", type, key, device, length), and None for no view in old files.

        Old files have the class of a module like this: ("module", class, its file, its text).
        """
        if word == "module" and not rest:
            return _of(kind, _Global)
        if word != "storage" or rest[1:] not in ((), (None,)):
            raise ValueError(word)
        storage = Storage(_DTYPES[kind], _of(key, str), _of(rest[0], int))
        if self.storages.setdefault(key, storage) != storage:
            raise ValueError(key)
        return storage

    def _called(self, function: Any, arguments: tuple) -> Any:
        """The result that a function named in the pickle would return."""
        if function == _TENSOR:
            storage, offset, shape, strides = arguments[:4]
            sizes = _integers(shape), _integers(strides)
            return Tensor(_of(storage, Storage), _of(offset, int), *sizes)
        if function == _PARAMETER:
            return _of(arguments[0], Tensor)
        if function == _DICTIONARY and arguments == ():
            return {}
        if function == _SIZE:
            (size,) = arguments
            return size
        if function != _METHOD:
            raise ValueError(function)
        module, name = arguments
        if name != "state_dict":
            self._refuse(f"{name} of a network")
        return _state_dict(_of(module, _Object))


def _state_dict(network: _Object) -> dict[str, Tensor]:
    """The tensors of a module and of all modules within, by name, as PyTorch's method does.

    No module may occur twice: a short pickle could contain one module exponentially often.
    """
    tensors: dict[str, Tensor] = {}
    found: set[_Object] = set()
    waiting = [("", network)]
    while waiting:
        prefix, module = waiting.pop()
        if module in found:
            raise ValueError(prefix)
        found.add(module)
        for kind in ("_parameters", "_buffers"):
            for name, tensor in _of(module.attributes[kind], dict).items():
                if tensor is not None:
                    tensors[f"{prefix}{name}"] = _of(tensor, Tensor)
        inner = _of(module.attributes["_modules"], dict).items()
        waiting += [(f"{prefix}{name}.", _of(part, _Object)) for name, part in inner][::-1]
    return tensors


def _of(value: Any, kind: type) -> Any:
    """The value, which must have exactly this type: a bool is no int."""
    if type(value) is not kind:
        raise TypeError(kind)
    return value


def _integers(values: Any) -> tuple[int, ...]:
    return tuple(_of(value, int) for value in _of(values, tuple))


def _set(target: Any, key: Any, value: Any) -> None:
    """Set an entry. Keys are text or numbers: the hash of nested tuples can take for ever."""
    if type(key) not in (str, int):
        raise TypeError(key)
    _of(target, dict)[key] = value
