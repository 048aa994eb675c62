"""The published networks in PyTorch's files, as parameters of this package's networks.

Layers are matched by the order in which a network defines them, Linear and LayerNorm each among
themselves, and every shape is checked. Networks, inputs and outputs are as in the authors' scripts
`model.py`, `layering.py` and `compress.py` (github.com/sssssy/pytorch-mitsuba-NLB_Release): the
direction inputs in the order of `inference.direction_inputs`, then the code; of the layering
network the upper and the lower code minus 1, albedo and sigma_t; its output is a code minus 1.
"""

import os
from collections.abc import Iterable

import numpy as np

from fan2022.architecture import EVALUATION, LAYERING, PROXY, Block, Linear, Norm, Skip, shapes
from fan2022.torch_files import state_dict
from urushi.errors import FileError


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


def _read(path: str | os.PathLike, network: str, chain: Iterable[Block]) -> dict[str, np.ndarray]:
    """The parameters of one network, by the names of `architecture`."""
    modules: dict[str, dict[str, np.ndarray]] = {}
    for name, tensor in state_dict(path).items():
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
            names = block.shapes()  # of the weight, then of the bias
            values = modules[module]["weight"].T, modules[module]["bias"]
            params |= zip(names, values, strict=True)
    return params


def _kind(module: str, parts: dict[str, np.ndarray], where: str) -> type:
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
