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

from fan2022.architecture import EVALUATION, LAYERING, PROXY, Block, Linear, Norm, Skip, shapes
from fan2022.pickled import Storage, Tensor, decode
from urushi.errors import FileError

#: Largest file, and largest pickle in it. The paper's networks have 12 MB, their pickles 30 kB.
MAX_FILE, MAX_PICKLE = 1 << 26, 1 << 20

#: Largest number of values of a tensor: sixteen times as many as the paper's largest tensor has.
MAX_VALUES = 1 << 22

#: First bytes of the format that PyTorch wrote before version 1.6, and the version of the format.
_LEGACY, _LEGACY_VERSION = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.", 1001

CURE = "give a file of torch.save(network.state_dict())"


class TorchFile:
    """A file of `torch.save`, of the zip format or the older one of PyTorch before 1.6 (2020).

    Attributes:
        content: the value of its pickle, see `pickled.decode`.
    """

    def __init__(self, path: str | os.PathLike) -> None:
        self.path = Path(path)
        try:
            with self.path.open("rb") as file:
                data = file.read(MAX_FILE + 1)
        except OSError as error:
            raise FileError(f"cannot read '{path}': {error.strerror}; check the path") from error
        if not data.startswith((_LEGACY, b"PK")):
            raise FileError(f"'{path}' is not a PyTorch file; give one written by torch.save")
        read = _read_legacy if data.startswith(_LEGACY) else _read_zip
        try:
            if len(data) > MAX_FILE:
                raise FileError(f"has more than {MAX_FILE} bytes; {CURE}")
            self.content, self._storages = read(data)
        except FileError as error:
            raise FileError(f"'{path}' {error}") from None
        except Exception as error:  # a damaged pickle raises many kinds
            raise FileError(
                f"'{path}' is damaged, or has more than tensors in dictionaries; {CURE}"
            ) from error

    def array(self, tensor: Tensor, name: str) -> np.ndarray:
        """The values of a tensor as a new float32 array; name: for errors."""
        (storage, offset, shape, strides), where = tensor, f"the tensor '{name}' of '{self.path}'"
        try:
            whole = np.frombuffer(self._storages[storage.key], storage.dtype)
            last = offset + sum((n - 1) * s for n, s in zip(shape, strides, strict=True))
            if min(offset, *shape, *strides) < 0 or math.prod(shape) > MAX_VALUES:
                raise ValueError(shape)
            if len(whole) != storage.length or last >= len(whole):
                raise ValueError(last)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise FileError(
                f"{where} lies outside its storage; download or save it again"
            ) from error
        steps = [step * whole.itemsize for step in strides]
        values = as_strided(whole[offset:], shape, steps, writeable=False)
        with np.errstate(over="ignore"):  # of doubles: refused below
            array = np.array(values, np.float32)
        if not np.isfinite(array).all():
            raise FileError(
                f"{where} holds a number that is not finite in single precision; give other weights"
            )
        return array


def _read_zip(data: bytes) -> tuple[Any, Mapping[str, bytes]]:
    """Content and storages of a zip file."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {member.filename: member for member in archive.infolist()}
        (name,) = (name for name in members if name.endswith("/data.pkl"))
        total = sum(member.file_size for member in members.values())
        if total > MAX_FILE:
            raise FileError(f"unpacks to {total} bytes, more than {MAX_FILE}; {CURE}")
        folder = name.removesuffix("data.pkl")
        if f"{folder}byteorder" in members and archive.read(f"{folder}byteorder") != b"little":
            raise FileError("has big-endian numbers; save it again on a little-endian machine")
        if members[name].file_size > MAX_PICKLE:
            raise FileError(f"has a pickle of more than {MAX_PICKLE} bytes; {CURE}")
        content, storages = decode(io.BytesIO(archive.read(name)))
        names = {key: f"{folder}data/{key}" for key in storages}
        return content, {k: archive.read(n) for k, n in names.items() if n in members}


def _read_legacy(data: bytes) -> tuple[Any, Mapping[str, bytes]]:
    """Content and storages of the older format.

    Five pickles follow each other: a number, the format's version, the machine, the content, and
    the keys of its storages. After them, each storage has its length, 8 bytes, and its values.
    """
    file = io.BytesIO(data[:MAX_PICKLE])
    _, version, machine = (decode(file)[0] for _ in range(3))
    if not machine["little_endian"]:
        raise FileError("has big-endian numbers; save it again on a little-endian machine")
    content, storages = decode(file)
    keys, _ = decode(file)
    found, place = {}, file.tell()
    for key in keys:
        storage: Storage = storages[key]
        end = place + 8 + storage.length * np.dtype(storage.dtype).itemsize
        found[key] = data[place + 8 : end]
        if int.from_bytes(data[place : place + 8], "little") != storage.length or end > len(data):
            raise ValueError(key)
        place = end
    if version != _LEGACY_VERSION:
        raise ValueError(version)
    return content, found


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
    entries = content.values() if isinstance(content, dict) else ()
    found = [value for value in (content, *entries) if _holds_tensors(value)]
    if len(found) != 1:
        raise FileError(
            f"'{file.path}' should hold one state dict and holds {len(found) or 'none'}; {CURE}"
        )
    return found[0]


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
    tensors = ", ".join(f"{name or 'itself'} {t.shape}" for name, t in parts.items())
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
