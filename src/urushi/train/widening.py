"""Wider hidden layers for a trained network, which at first computes what it did before."""

import numpy as np

from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, Params, layer_sizes


def widened(
    params: Params, arch: Architecture, part: str, widths: tuple[int, ...], seed: int
) -> dict[str, np.ndarray]:
    """The parameters of one network with hidden layers of other widths (Chen et al. 2016).

    New neurons see all of the layer below by random weights, and weigh nothing in what the old
    ones above see, or the output: values and derivatives by the old parameters stay as they were.

    Args:
        params: all parameters, of the sizes `arch`.
        arch: the sizes before.
        part: the network, one of `architecture.PARTS`.
        widths: of its hidden layers, as many as before and none of them less.
        seed: of the new neurons' weights.

    Raises:
        ParameterError: the widths are not such.
    """
    before = getattr(arch, part)
    pairs = zip(before, widths, strict=False)
    if len(widths) != len(before) or any(new < old for old, new in pairs):
        raise ParameterError(
            f"the {part} has hidden layers of {before} neurons, which cannot be widened to {widths}"
        )
    rng = np.random.default_rng(seed)
    old = layer_sizes(arch, part)
    new = (old[0], *widths, old[-1])
    wide: dict[str, np.ndarray] = {}
    for index in range(len(new) - 1):
        rows, columns = new[index : index + 2]
        weight = rng.standard_normal((rows, columns)) * np.sqrt(2.0 / rows)
        weight[:, : old[index + 1]] = 0.0
        weight[: old[index], : old[index + 1]] = params[f"{part}.{index}.weight"]
        bias = np.zeros(columns)
        bias[: old[index + 1]] = params[f"{part}.{index}.bias"]
        wide[f"{part}.{index}.weight"] = weight.astype(np.float32)
        wide[f"{part}.{index}.bias"] = bias.astype(np.float32)
    return wide
