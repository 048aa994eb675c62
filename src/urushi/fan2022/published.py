"""The published networks in PyTorch's files, as parameters of Urushi's.

Layers are matched by the order in which a network defines them, Linear and LayerNorm each among
themselves, and every shape is checked. Networks, inputs and outputs are as in the authors' scripts
`model.py`, `layering.py` and `compress.py` (github.com/sssssy/pytorch-mitsuba-NLB_Release): the
direction inputs in the order of `inference.direction_inputs`, then the code; of the layering
network the upper and the lower code minus 1, albedo and sigma_t; its output is a code minus 1.
"""

import os
from collections.abc import Iterable
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.fan2022.architecture import EVALUATION, LAYERING, PROXY
from urushi.fan2022.blocks import Block, Linear, Norm, Skip, shapes
from urushi.fan2022.pickled import Tensor
from urushi.fan2022.torch_file import TorchFile

#: Output of a sampler without training, for the least share of the Gaussian.
_COSINE_OUTPUT = 20.0


def networks(
    representation: str | os.PathLike, layering: str | os.PathLike
) -> dict[str, np.ndarray]:
    """Return the parameters of the evaluation and the layering network from two files.

    Raises:
        FileError: a file cannot be read, see `torch_file`, or does not fit the paper's network.
    """
    params = _read(representation, "representation", EVALUATION)
    params |= _read(layering, "layering", LAYERING)
    return params


def cosine_proxy() -> dict[str, np.ndarray]:
    """Parameters of a sampling proxy that gives the cosine lobe its greatest share, 98 %."""
    params = {name: np.zeros(shape, np.float32) for name, shape in shapes(PROXY).items()}
    params[f"{PROXY[-1].name}.bias"][1] = _COSINE_OUTPUT
    return params


def state_dict(file: TorchFile) -> dict[str, Tensor]:
    """The tensors by name: the file's content, or the one entry of it that is such a dictionary.

    Raises:
        FileError: there is none, or several.
    """
    content = file.content
    entries = content if isinstance(content, dict) else {}
    if _holds_tensors(content):
        return content
    found = [key for key, value in entries.items() if _holds_tensors(value)]
    if len(found) != 1:
        several = f"several state dicts ({', '.join(map(str, found))})" if found else "none"
        raise FileError(
            f"'{file.path}' should hold one state dict and holds {several}; "
            "give a file of torch.save(network.state_dict())"
        )
    return entries[found[0]]


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
    tensors = state_dict(file)
    modules: dict[str, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
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
            shape, asked = modules[module]["weight"].shape, _torch_shape(block)
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


def _torch_shape(block: Linear | Norm) -> tuple[int, ...]:
    """The shape of a layer's weight in PyTorch, whose matrices are (out, in)."""
    return (block.columns, block.rows) if isinstance(block, Linear) else (block.width,)


def flat(chain: Iterable[Block]) -> list[Linear | Norm]:
    """The layers of a chain, those inside of skips too, in the order of evaluation."""
    layers: list[Linear | Norm] = []
    for block in chain:
        layers += flat(block.inner) if isinstance(block, Skip) else [block]
    return layers
