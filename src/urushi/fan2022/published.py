"""The published networks in PyTorch's files, read with NumPy alone, as parameters of Urushi's.

Layers are matched by the order in which a network defines them, Linear and LayerNorm each among
themselves, and every shape is checked. Networks, inputs and outputs are as in the authors' scripts
`model.py`, `layering.py` and `compress.py` (github.com/sssssy/pytorch-mitsuba-NLB_Release): the
direction inputs in the order of `inference.direction_inputs`, then the code; of the layering
network the upper and the lower code minus 1, albedo and sigma_t; its output is a code minus 1.
"""

import io
import math
import os
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided

from urushi.errors import FileError
from urushi.fan2022.architecture import (
    EVALUATION,
    LAYERING,
    PROXY,
    Block,
    Linear,
    Norm,
    Skip,
    shapes,
)
from urushi.fan2022.pickled import Tensor, decode

#: Largest file, and largest pickle in it. The paper's networks have 12 MB, their pickles 30 kB.
MAX_FILE, MAX_PICKLE = 1 << 26, 1 << 20

#: Largest number of values of a tensor: sixteen times as many as the paper's largest tensor has.
MAX_VALUES = 1 << 22

#: First bytes of the format that PyTorch wrote before version 1.6, and the version of the format.
_LEGACY, _LEGACY_VERSION = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.", 1001


class TorchFile:
    """A file of `torch.save`, of the zip format or the older one of PyTorch before 1.6 (2020)."""

    def __init__(self, path: str | os.PathLike) -> None:
        """Read a file's pickle, `content` as of `pickled.decode`, and its storages, for `array`."""
        self.path = Path(path)
        data = _content(self.path)
        read = _read_legacy if data.startswith(_LEGACY) else _read_zip
        self.content, self._storages = read(data, self.path)

    def array(self, tensor: Tensor, name: str) -> np.ndarray:
        """The values of a tensor as a new float32 array; name: for errors."""
        (storage, offset, shape, strides), where = tensor, f"the tensor '{name}' of '{self.path}'"
        if len(shape) != len(strides) or min((offset, *shape, *strides), default=0) < 0:
            raise FileError(f"{where} has a wrong shape; save it again")
        if math.prod(shape) > MAX_VALUES:
            raise FileError(
                f"{where} has shape {shape}; the paper's networks have at most {MAX_VALUES} values "
                "in one"
            )
        last = offset + sum((n - 1) * s for n, s in zip(shape, strides, strict=True))
        if 0 not in shape and last >= storage.length:
            raise FileError(f"{where} lies outside its storage; save it again")
        dtype = np.dtype(storage.dtype)
        data = self._storages.get(storage.key)
        if data is None:
            raise FileError(
                f"'{self.path}' lacks the values of the tensor '{name}'; download or save it again"
            )
        if len(data) != storage.length * dtype.itemsize:
            raise FileError(
                f"the storage of {where} has {len(data)} bytes instead of "
                f"{storage.length * dtype.itemsize}; download or save the file again"
            )
        values = np.frombuffer(data, dtype)[offset:]
        steps = tuple(s * dtype.itemsize for s in strides)
        view = as_strided(values, shape, steps, writeable=False)
        with np.errstate(over="ignore"):  # of doubles: refused below
            array = np.array(view, np.float32, order="C")
        if not np.isfinite(array).all():
            raise FileError(
                f"{where} holds a number that is not finite in single precision; give other weights"
            )
        return array


def _content(path: Path) -> bytes:
    """All bytes of a file, at most `MAX_FILE`."""
    try:
        size = path.stat().st_size
        if size > MAX_FILE:
            raise FileError(
                f"'{path}' has {size} bytes, and files of the paper's networks at most {MAX_FILE}; "
                "give a file of torch.save(network.state_dict())"
            )
        with path.open("rb") as file:
            data = file.read(MAX_FILE)
    except OSError as error:
        raise FileError(
            f"cannot read '{path}': {error.strerror or error}; check the path"
        ) from error
    if not data.startswith((_LEGACY, b"PK")):
        raise FileError(f"'{path}' is not a PyTorch file; give one written by torch.save")
    return data


def _read_zip(data: bytes, path: Path) -> tuple[Any, Mapping[str, bytes]]:
    """Content and storages of a zip file, whose members are not compressed and do not overlap."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {member.filename: member for member in archive.infolist()}
            if any(m.compress_type != zipfile.ZIP_STORED for m in members.values()):
                raise FileError(
                    f"'{path}' is compressed, but torch.save never compresses; save it again"
                )
            if sum(member.file_size for member in members.values()) > MAX_FILE:
                raise _damaged(path)
            names = [name for name in members if name.endswith("/data.pkl")]
            if len(names) != 1:
                raise FileError(
                    f"'{path}' is a zip file, but not one of torch.save; "
                    "give a file of torch.save(network.state_dict())"
                )
            size = members[names[0]].file_size
            if size > MAX_PICKLE:
                raise FileError(
                    f"'{names[0]}' in '{path}' has {size} bytes, more than {MAX_PICKLE}; "
                    "give a file of torch.save(network.state_dict())"
                )
            folder = names[0].removesuffix("data.pkl")
            order = members.get(f"{folder}byteorder")
            if order is not None and archive.read(order) != b"little":
                raise _big_endian(path)
            content, storages = decode(io.BytesIO(archive.read(names[0])), path)
            places = {key: members.get(f"{folder}data/{key}") for key in storages}
            return content, {k: archive.read(m) for k, m in places.items() if m is not None}
    except FileError:
        raise
    except (OSError, EOFError, RuntimeError, ValueError, zipfile.BadZipFile) as error:
        raise _damaged(path) from error


def _read_legacy(data: bytes, path: Path) -> tuple[Any, Mapping[str, bytes]]:
    """Content and storages of the older format.

    Five pickles follow each other: a number, the format's version, the machine, the content, and
    the keys of its storages. After them, each storage has its length, 8 bytes, and its values.
    """
    file = io.BytesIO(data[:MAX_PICKLE])
    _, version, machine = (decode(file, path)[0] for _ in range(3))
    content, storages = decode(file, path)
    keys, _ = decode(file, path)
    if version != _LEGACY_VERSION or not isinstance(machine, dict) or not isinstance(keys, list):
        raise _damaged(path)
    if machine.get("little_endian") is not True:
        raise _big_endian(path)
    found, place = {}, file.tell()
    for key in keys:
        if type(key) is not str or key not in storages:
            raise _damaged(path)
        storage = storages[key]
        end = place + 8 + storage.length * np.dtype(storage.dtype).itemsize
        if int.from_bytes(data[place : place + 8], "little") != storage.length or end > len(data):
            raise _damaged(path)
        found[key] = data[place + 8 : end]
        place = end
    return content, found


def _big_endian(path: Path) -> FileError:
    return FileError(f"'{path}' has big-endian numbers; save it again on a little-endian machine")


def _damaged(path: Path) -> FileError:
    return FileError(f"'{path}' is truncated or damaged; download or save it again")


def networks(
    representation: str | os.PathLike, layering: str | os.PathLike
) -> dict[str, np.ndarray]:
    """Return the parameters of the evaluation and the layering network from two files."""
    evaluation = _read(representation, "representation", EVALUATION)
    return evaluation | _read(layering, "layering", LAYERING)


def cosine_proxy() -> dict[str, np.ndarray]:
    """Parameters of a sampling proxy that gives the cosine lobe its greatest share, 98 %."""
    params = {name: np.zeros(shape, np.float32) for name, shape in shapes(PROXY).items()}
    params[f"{PROXY[-1].name}.bias"][1] = 20.0  # the least share of the Gaussian
    return params


def state_dict(file: TorchFile) -> dict[str, Tensor]:
    """The tensors by name: the file's content, or its one entry that is a dictionary of tensors."""
    content = file.content
    if _holds_tensors(content):
        return content
    entries = content.items() if isinstance(content, dict) else ()
    found = {key: value for key, value in entries if _holds_tensors(value)}
    if len(found) != 1:
        several = f"several state dicts ({', '.join(map(str, found))})" if found else "none"
        raise FileError(
            f"'{file.path}' should hold one state dict and holds {several}; "
            "give a file of torch.save(network.state_dict())"
        )
    return next(iter(found.values()))


def _holds_tensors(value: Any) -> bool:
    """Whether a value is a dictionary of tensors by name."""
    return (
        isinstance(value, dict)
        and len(value) > 0
        and all(isinstance(k, str) and isinstance(v, Tensor) for k, v in value.items())
    )


def _read(path: str | os.PathLike, network: str, chain: Iterable[Block]) -> dict[str, np.ndarray]:
    """The parameters of one network, by Urushi's names."""
    file = TorchFile(path)
    modules: dict[str, dict[str, Tensor]] = {}
    for name, tensor in state_dict(file).items():
        module, _, part = name.rpartition(".")
        modules.setdefault(module, {})[part] = tensor
    where = f"the {network} network in '{path}'"
    found: dict[type, list[str]] = {Linear: [], Norm: []}
    for module, parts in modules.items():
        found[_kind(module, parts, where)].append(module)
    params: dict[str, np.ndarray] = {}
    for kind, word in ((Linear, "Linear"), (Norm, "LayerNorm")):
        expected = [block for block in flat(chain) if isinstance(block, kind)]
        if len(found[kind]) != len(expected):
            raise FileError(
                f"{where} has {len(found[kind])} layers of kind {word}, the paper's has "
                f"{len(expected)}; give the representation network first, then the layering one"
            )
        for number, (module, block) in enumerate(zip(found[kind], expected, strict=True), 1):
            shape = modules[module]["weight"].shape
            asked = tuple(next(iter(block.shapes().values())))[::-1]  # matrices are (out, in)
            if shape != asked:
                raise FileError(
                    f"{word} {number} of {where}, '{module}', has a weight of shape {shape}, "
                    f"the paper's has {asked}; give networks that define their layers in the "
                    "paper's order"
                )
            weight, bias = (
                file.array(modules[module][part], f"{module}.{part}") for part in ("weight", "bias")
            )
            names = block.shapes()  # of the weight, then of the bias
            params |= zip(names, (weight.T, bias), strict=True)
    return params


def _kind(module: str, parts: dict[str, Tensor], where: str) -> type:
    """Linear or Norm, by the shapes of a module's tensors."""
    if set(parts) == {"weight", "bias"}:
        weight, bias = parts["weight"].shape, parts["bias"].shape
        if len(weight) in (1, 2) and bias == weight[:1]:
            return Linear if len(weight) == 2 else Norm
    tensors = ", ".join(f"{name or 'itself'} {tuple(t.shape)}" for name, t in parts.items())
    raise FileError(
        f"the layer '{module}' of {where} is neither a Linear nor a LayerNorm layer ({tensors}); "
        "give the state dict of the paper's network alone"
    )


def flat(chain: Iterable[Block]) -> list[Linear | Norm]:
    """The layers of a chain and of the skips in it, in the order of evaluation."""
    layers: list[Linear | Norm] = []
    for block in chain:
        layers += flat(block.inner) if isinstance(block, Skip) else [block]
    return layers
