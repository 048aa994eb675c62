"""Slopes of the tables of coats, by differences of light transport.

Where f of a coated material is a table by light transport, its codes have the derivative of
another f. Transport is linear in what lies below the interface, so that many channels cost little
more than one (`coated_table`): every change of a parameter, up and down, is a channel of one table.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from urushi.checks import ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP, CoatParameters
from urushi.material.layer import layer_material
from urushi.material.material import Material
from urushi.material.table import table_of_values

#: Relative change of f by a step of the bottom, at all but a tenth of the nodes, and at most.
CHANGE, QUANTILE, MOST = 0.1, 0.9, 0.5

#: Steps of the coat's parameters, relative for alpha, and their ranges.
STEPS = CoatParameters(0.1, 0.02, 0.02, 0.05, 0.05)
RANGES = CoatParameters((MIN_ALPHA, 1.0), ETA_RANGE, (0.0, 1.0), (0.0, np.inf), (-0.98, 0.98))


class Slope(NamedTuple):
    """Derivatives of what a channel of a coated material is made of, by one number.

    Attributes:
        channel: its index.
        parameter: the name of the coat's parameter that is the number; None: it is the bottom's.
        values: (N,) derivative of the bottom's table as f at `node_pairs`; None: there is none.
        code: (L,) derivative of the bottom's code; None: it vanishes.
    """

    channel: int
    parameter: str | None = None
    values: np.ndarray | None = None
    code: np.ndarray | None = None


def table_slopes(coat: CoatParameters, bottom: Material, slopes: Sequence[Slope]) -> np.ndarray:
    """Derivatives float32 (K, N), by K numbers, of ln f at the nodes of `layer_material`'s table.

    coat, bottom: as of `layer_material`, which gives a table; the coat has one width.
    """
    steps = [_step(coat, bottom, slope) for slope in slopes]
    up, down = np.array(steps).T
    changed = [*zip(up.tolist(), slopes, strict=True), *zip(down.tolist(), slopes, strict=True)]
    columns, codes, values = [], [], []
    for step, slope in changed:
        c = slope.channel
        own = {name: float(np.resize(x, bottom.channels)[c]) for name, x in coat._asdict().items()}
        if slope.parameter:
            own[slope.parameter] += step
        columns.append(list(own.values()))
        codes.append(bottom.latents[c] + (0 if slope.code is None else step * slope.code))
        if bottom.table is not None:
            f = np.exp(bottom.table[..., c].astype(np.float64).ravel())
            if slope.values is not None:
                f *= 1 + np.clip(step * slope.values / f, -MOST, MOST)
            values.append(f)
    table = None if bottom.table is None else table_of_values(np.stack(values, axis=-1))
    below = replace(bottom, latents=np.stack(codes), anchors=np.stack(codes), table=table)
    coated = layer_material(CoatParameters.of_columns(np.array(columns).T), below).table
    assert coated is not None  # for the type checker
    high, low = np.split(coated.reshape(-1, len(changed)).T.astype(np.float32), 2)
    return (high - low) / (up - down).astype(np.float32)[:, None]


def _step(coat: CoatParameters, bottom: Material, slope: Slope) -> tuple[float, float]:
    """Changes of the number, up and down; one of them is 0 at the end of a parameter's range."""
    if slope.parameter:
        value = float(np.resize(getattr(coat, slope.parameter), bottom.channels)[slope.channel])
        size, (least, most) = (getattr(x, slope.parameter) for x in (STEPS, RANGES))
        if slope.parameter == "alpha":
            size *= value
        if slope.parameter == "eta":  # an index near one remains on its side
            side = value > 1
            least, most = (1 + MIN_INDEX_STEP, most) if side else (least, 1 - MIN_INDEX_STEP)
        return min(value + size, most) - value, max(value - size, least) - value
    if slope.values is not None and bottom.table is not None:
        f = np.exp(bottom.table[..., slope.channel].astype(np.float64).ravel())
        largest = float(np.quantile(np.abs(slope.values) / f, QUANTILE))
    else:
        largest = float(np.abs(slope.code).max()) if slope.code is not None else 0.0
    size = CHANGE / max(largest, 1e-6)
    return size, -size
