"""Constant coats by light transport with gradients: of the coat, and of what lies below it.

ln f at the nodes of a table, and the numbers of a code, are linear in every number that carries a
gradient. The slopes are differences of light transport at the probe pairs: every change of a
number, up and down, is a channel under a coat of its own. A change of f at the probe pairs is a
change of the code, which is a change of ln f at all nodes. How the bottom changes with a number is
found by Dr.Jit's forward mode.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import COAT_COLUMNS, ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP, CoatParameters
from urushi.core.table import table_of_values
from urushi.material.coated_values import coated_f
from urushi.material.layer import with_widths
from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.coding import stacked
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import TWO_WIDTHS, CoatTextures
from urushi.nets import code_fit
from urushi.nets import lobe as lobes
from urushi.nets.lobe import WIDTH_PLACES
from urushi.textures.layering import transported_rests

#: Relative change of f by a step of the bottom, at all but a tenth of the nodes, and at most.
CHANGE, QUANTILE, MOST = 0.1, 0.9, 0.5

#: Steps of the coat's parameters, relative for widths, and their ranges.
STEPS = {"alpha": 0.1, "eta": 0.02, "albedo": 0.02, "sigma_t": 0.05, "g": 0.05}
RANGES = {
    "alpha": (MIN_ALPHA, 1.0),
    "eta": ETA_RANGE,
    "albedo": (0.0, 1.0),
    "sigma_t": (0.0, np.inf),
    "g": (-0.98, 0.98),
}


class Slope(NamedTuple):
    """Derivatives of a channel's coat and bottom with respect to one number."""

    channel: int
    columns: tuple[str, ...] = ()  # of the coat that the number sets; none: it is the bottom's
    # (N,) derivative of the bottom's table as f at `node_pairs`; None: there is none.
    values: np.ndarray | None = None
    code: np.ndarray | None = None  # (L,) derivative of the bottom's code; None: it vanishes


def code_slopes(
    material: Material, coat: CoatParameters, bottom: Material, slopes: Sequence[Slope]
) -> np.ndarray:
    """Derivatives (K, R), by K numbers, of the numbers of a material's codes beside their lobes.

    material: of `layer_material` by coat and bottom.
    """
    model, pairs = material.model, material.model.networks.pairs()
    given = dict(zip(COAT_COLUMNS[model.widths], coat.columns(), strict=True))
    steps = [_step(given, bottom, slope) for slope in slopes]
    up, down = np.array(steps).T
    changed = [*zip(up.tolist(), slopes, strict=True), *zip(down.tolist(), slopes, strict=True)]
    rows, codes, values = [], [], []
    for step, slope in changed:
        c = slope.channel
        own = {name: float(np.resize(x, bottom.channels)[c]) for name, x in given.items()}
        rows.append([x + step * (name in slope.columns) for name, x in own.items()])
        codes.append(bottom.latents[c] + (0 if slope.code is None else step * slope.code))
        if bottom.table is not None:
            f = np.exp(bottom.table[..., c].astype(np.float64).ravel())
            if slope.values is not None:
                f *= 1 + np.clip(step * slope.values / f, -MOST, MOST)
            values.append(f)
    coats, z = CoatParameters.of_columns(np.array(rows).T), np.stack(codes)
    if bottom.table is None:
        f = transported_rests(model, z, coats)
    else:
        table = table_of_values(np.stack(values, axis=-1))
        f = coated_f(replace(bottom, latents=z, table=table), coats, *pairs).T
    high, low = np.split(f, 2)
    changes = (high - low) / (up - down)[:, None]
    size = model.arch.lobe
    top = lobes.f(material.latents[:, None, :size], *pairs)
    rest = np.maximum(material.f(*pairs).T - top, 0)
    by_rests = code_fit.slopes(model.networks.basis, rest, material.latents[:, size:])
    pieces = zip(changes, slopes, strict=True)
    return np.array([change @ by_rests[slope.channel] for change, slope in pieces])


def _step(given: dict, bottom: Material, slope: Slope) -> tuple[float, float]:
    """Changes of the number, up and down; one of them is 0 at the end of a parameter's range."""
    if slope.columns:
        name = slope.columns[0]
        value = float(np.resize(given[name], bottom.channels)[slope.channel])
        kind = "alpha" if name.startswith("alpha") else name
        size, (least, most) = STEPS[kind], RANGES[kind]
        if kind == "alpha":
            size *= value
        if kind == "eta":  # an index near one remains on its side
            side = value > 1
            least, most = (1 + MIN_INDEX_STEP, most) if side else (least, 1 - MIN_INDEX_STEP)
        return min(value + size, most) - value, max(value - size, least) - value
    largest = 1e-6
    if slope.values is not None and bottom.table is not None:
        f = np.exp(bottom.table[..., slope.channel].astype(np.float64).ravel())
        largest = max(largest, np.quantile(np.abs(slope.values) / f, QUANTILE))
    if slope.code is not None:
        z, networks = bottom.latents[slope.channel], bottom.model.networks
        size, widths = bottom.model.arch.lobe, list(WIDTH_PLACES[bottom.model.widths])
        rows = networks.functions(z, networks.features(*networks.pairs()))[:, 1:]
        of_lobe, of_logs = slope.code[:size].copy(), rows @ slope.code[size : size + rows.shape[1]]
        of_lobe[widths] /= z[widths]
        largest = max(largest, np.abs(of_lobe).max(), np.quantile(np.abs(of_logs), QUANTILE))
    size = CHANGE / float(largest)
    return size, -size


def attached(
    material: Material,
    coat: CoatTextures,
    below: Material,
    parameters: Sequence,
    values: Sequence,
    codes: "mi.TensorXf | None",
) -> list:
    """ln f of each channel at the nodes, or of two widths the numbers of its code beside the lobe.

    Dr.Jit floats (N) with gradients.

    Args:
        material: the coated material, which has the table or the code.
        coat, below: its coat and its bottom.
        parameters: of the bottom, flat Dr.Jit arrays that carry gradients.
        values: f of each channel of the bottom's table; empty: the table follows the codes.
        codes: (1, C, L) of the bottom; None: its lobe does not change.
    """
    widths, size = material.model.widths, material.model.arch.lobe
    plain = material.latents[:, size:]
    if widths == 1:
        assert material.table is not None  # for the type checker
        plain = material.table.reshape(-1, material.channels).T.astype(np.float32)
    numbers = [mi.Float(np.ascontiguousarray(channel)) for channel in plain]
    uv = np.full((1, 2), 0.5)
    changes: list[tuple[Any, list[Slope]]] = []
    for name, given in coat.channels(probing.interaction(np.array([[0.0, 0.0, 1.0]]), uv)).items():
        for channel, number in enumerate(given):
            if dr.grad_enabled(number):
                shared = range(material.channels) if len(given) == 1 else [channel]
                names = TWO_WIDTHS if (name, widths) == ("alpha", 2) else (name,)
                changes.append((number, [Slope(c, names) for c in shared]))
    outputs = [*values] if codes is None else [*values, codes.array]
    for number, derivatives in _derivatives(parameters, outputs):
        nothing = [None] * material.channels
        of_values = derivatives[: len(values)] or nothing
        of_codes = nothing if codes is None else [*derivatives[-1].reshape(codes.shape[1:])]
        parts = zip(of_values, of_codes, strict=True)
        slopes = [Slope(c, (), *pair) for c, pair in enumerate(parts)]
        changes.append((number, [x for x in slopes if any(np.any(y) for y in x[2:])]))
    flat = [slope for _, slopes in changes for slope in slopes]
    if flat:
        columns = [column[0] for column in coat.layering(uv).columns()]
        own = with_widths(material.model, CoatParameters.of_columns(columns))
        found = code_slopes(material, own, below, flat)
        if widths == 1:
            found = found @ material.model.networks.basis.rows[:, 1:].T
        by_numbers = iter(found.astype(np.float32))
        for number, slopes in changes:
            change = number - dr.detach(number)
            for slope, by_number in zip(slopes, by_numbers, strict=False):
                numbers[slope.channel] = dr.fma(change, mi.Float(by_number), numbers[slope.channel])
    return numbers


def _derivatives(parameters: Sequence, outputs: Sequence) -> Iterator[tuple[Any, list[np.ndarray]]]:
    """Each number of the parameters, and the derivatives of the outputs by it.

    The parameters may be results of others, which keep their gradients.
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
        other = forward(units[0][0], -1)  # by gradients of those others alone
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
