"""The published networks as parameters of Urushi's, from NumPy files of their tensors.

`docs/published.md` shows how PyTorch writes these files. Layers are matched by the order in which a
network defines them, Linear and LayerNorm each among themselves, and every shape is checked.
Networks, inputs and outputs are as in the authors' scripts `model.py`, `layering.py` and
`compress.py` (github.com/sssssy/pytorch-mitsuba-NLB_Release): the direction inputs in the order of
`inference.direction_inputs`, then the code; of the layering network the upper and the lower code
minus 1, albedo and sigma_t; its output is a code minus 1.
"""

import os
from collections.abc import Iterable

import numpy as np

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
from urushi.files import read_npz

#: Output of a sampler without training, for the least share of the Gaussian.
_COSINE_OUTPUT = 20.0


def networks(
    representation: str | os.PathLike, layering: str | os.PathLike
) -> dict[str, np.ndarray]:
    """The parameters of the evaluation and the layering network from two files (.npz)."""
    params = _read(representation, "representation", EVALUATION)
    params |= _read(layering, "layering", LAYERING)
    return params


def cosine_proxy() -> dict[str, np.ndarray]:
    """Parameters of a sampling proxy that gives the cosine lobe its greatest share, 98 %."""
    params = {name: np.zeros(shape, np.float32) for name, shape in shapes(PROXY).items()}
    params[f"{PROXY[-1].name}.bias"][1] = _COSINE_OUTPUT
    return params


def _read(path: str | os.PathLike, network: str, chain: Iterable[Block]) -> dict[str, np.ndarray]:
    """The parameters of one network, by Urushi's names."""
    modules: dict[str, dict[str, np.ndarray]] = {}
    for name, tensor in read_npz(path).items():
        if tensor.dtype.kind != "f":
            raise FileError(
                f"'{path}' has the array '{name}', which is not of floats; leave it out"
            )
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
            with np.errstate(over="ignore"):  # of doubles: refused below
                arrays = [modules[module][part].astype(np.float32) for part in ("weight", "bias")]
            shape, asked = arrays[0].shape, _torch_shape(block)
            if shape != asked:
                raise FileError(
                    f"{word} {number} of {where}, '{module}', has a weight of shape {shape}, "
                    f"the paper's has {asked}; give networks that define their layers in the "
                    "paper's order"
                )
            if not all(np.isfinite(array).all() for array in arrays):
                raise FileError(
                    f"{word} {number} of {where}, '{module}', holds a number that is not finite in "
                    "single precision; give other weights"
                )
            # The shapes of a block are of its weight, then of its bias.
            params |= zip(
                block.shapes(), (np.ascontiguousarray(arrays[0].T), arrays[1]), strict=True
            )
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


def _torch_shape(block: Linear | Norm) -> tuple[int, ...]:
    """The shape of a layer's weight in PyTorch, whose matrices are (out, in)."""
    return (block.columns, block.rows) if isinstance(block, Linear) else (block.width,)


def flat(chain: Iterable[Block]) -> list[Linear | Norm]:
    """The layers of a chain, those inside of skips too, in the order of evaluation."""
    layers: list[Linear | Norm] = []
    for block in chain:
        layers += flat(block.inner) if isinstance(block, Skip) else [block]
    return layers
