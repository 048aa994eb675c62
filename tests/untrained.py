"""Models with smooth random functions and random networks, for properties of any weights."""

import itertools

import numpy as np

from urushi.core.table import SHAPE
from urushi.nets.networks import Architecture
from urushi.nets.weights import Model


def untrained(seed: int = 0, *, spread: float = 0.3, **sizes) -> Model:
    """A model with sizes as of `Architecture`, small by default.

    spread: standard deviation of the functions about zero. f is about 0.1 for a code of zeros.
    """
    small = {"functions": 8, "probes": 96, "layerer": (24, 24)}
    arch = Architecture(**small | sizes)
    rng, params = np.random.default_rng(seed), {}
    for name, shape in arch.parameter_shapes().items():
        scale = 0.1 if name.endswith(".bias") else shape[0] ** -0.5
        params[name] = scale * rng.standard_normal(shape)
    params["basis.rows"] = _functions(arch, rng, spread)
    params["basis.measure"] = np.full(arch.probes, 1 / arch.probes)
    params["basis.prior"] = np.eye(arch.functions)
    params["proposal.overlap"] = np.full(3, 0.5)
    return Model.of(arch, params, {"preset": "untrained"})


def _functions(arch: Architecture, rng: np.random.Generator, spread: float) -> np.ndarray:
    """Mean, one, and cosines of the coordinates with random amplitudes, (P, 1 + K)."""
    orders = sorted(itertools.product(range(4), repeat=len(SHAPE)), key=sum)
    columns = []
    for order in orders[: arch.functions]:
        axes = (np.cos(np.pi * n * np.linspace(0, 1, c)) for n, c in zip(order, SHAPE, strict=True))
        grid = np.ones(1)
        for axis in axes:
            grid = np.multiply.outer(grid, axis)
        columns.append(grid.ravel())
    waves = np.stack(columns, axis=-1)[:, 1:]
    mixed = spread * waves @ np.linalg.qr(rng.standard_normal((waves.shape[1],) * 2))[0]
    mean = -2.3 + 0.5 * waves @ rng.standard_normal(waves.shape[1])
    return np.column_stack([mean, np.ones(len(waves)), mixed]).astype(np.float16)  # as files
