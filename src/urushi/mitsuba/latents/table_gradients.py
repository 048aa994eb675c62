"""Tables by light transport with gradients: of the coat, and of what lies below it.

ln f at the nodes of a table is linear in every number that carries a gradient, with the slopes of
`material.table_slopes`. How the bottom changes with a number is found by Dr.Jit's forward mode.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import CoatParameters
from urushi.material.material import Material
from urushi.material.table_slopes import Slope, table_slopes
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.coding import stacked
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import CoatTextures


def attached(
    material: Material,
    coat: CoatTextures,
    below: Material,
    parameters: Sequence,
    values: Sequence,
    codes: "mi.TensorXf | None",
) -> list:
    """ln f of each channel at the nodes of a table, Dr.Jit floats (N) with gradients.

    Args:
        material: the coated material, which has the table.
        coat, below: its coat and its bottom.
        parameters: of the bottom, flat Dr.Jit arrays that carry gradients.
        values: f of each channel of the bottom's table; empty: the table follows the codes.
        codes: (1, C, L) of the bottom; None: its lobe does not change.
    """
    assert material.table is not None  # for the type checker
    logs = material.table.reshape(-1, material.channels).T.astype(np.float32)
    table = [mi.Float(channel) for channel in logs]
    uv = np.full((1, 2), 0.5)
    changes: list[tuple[Any, list[Slope]]] = []
    for name, given in coat.channels(probing.interaction(np.array([[0.0, 0.0, 1.0]]), uv)).items():
        for channel, number in enumerate(given):
            if dr.grad_enabled(number):
                shared = range(material.channels) if len(given) == 1 else [channel]
                changes.append((number, [Slope(c, name) for c in shared]))
    outputs = [*values] if codes is None else [*values, codes.array]
    for number, derivatives in _derivatives(parameters, outputs):
        nothing = [None] * material.channels
        of_values = derivatives[: len(values)] or nothing
        of_codes = nothing if codes is None else [*derivatives[-1].reshape(codes.shape[1:])]
        parts = zip(of_values, of_codes, strict=True)
        slopes = [Slope(c, None, *pair) for c, pair in enumerate(parts)]
        changes.append((number, [x for x in slopes if any(np.any(y) for y in x[2:])]))
    flat = [slope for _, slopes in changes for slope in slopes]
    if flat:
        columns = [column[0] for column in coat.layering(uv).columns()]
        found = iter(table_slopes(CoatParameters.of_columns(columns), below, flat))
        for number, slopes in changes:
            for slope, by_number in zip(slopes, found, strict=False):
                change = number - dr.detach(number)
                table[slope.channel] = dr.fma(change, mi.Float(by_number), table[slope.channel])
    return table


def _derivatives(parameters: Sequence, outputs: Sequence) -> Iterator[tuple[Any, list[np.ndarray]]]:
    """Each number of the parameters, and the derivatives of the outputs by it.

    The parameters may be results themselves: what they were computed from keeps its gradients.
    """
    kept = [dr.grad(array) for array in parameters]
    units = [(array, i) for array in parameters for i in range(len(array))]

    def forward(array: Any, i: int) -> list[np.ndarray]:
        for other in parameters:
            dr.set_grad(other, 0)
        dr.set_grad(array, mi.Float(np.arange(len(array)) == i))
        for output in outputs:
            dr.set_grad(output, 0)
        dr.forward_to(outputs, flags=dr.ADFlag.ClearInterior)
        return [np.array(dr.grad(output), copy=True) for output in outputs]

    if units and any(map(dr.grad_enabled, outputs)):
        other = forward(units[0][0], -1)  # by gradients of what the parameters were computed from
        for array, i in units:
            found = [x - y for x, y in zip(forward(array, i), other, strict=True)]
            yield dr.gather(mi.Float, array, i), found
    for array, gradient in zip(parameters, kept, strict=True):
        dr.set_grad(array, gradient)


def interleaved(logs: Sequence) -> "mi.TensorXf":
    """The channels (N) of a table in one, as `networks.table` looks them up."""
    if len(logs) == spectrum.COUNT:
        return mi.TensorXf(dr.concat(logs))
    size, count = 1 << (len(logs) - 1).bit_length(), len(logs[0])
    padding = [mi.Float(0)] * (size - len(logs))
    return mi.TensorXf(stacked([*logs, *padding], count).array)
