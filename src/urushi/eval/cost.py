"""Sizes and times of networks, which are reported without aims."""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.material import encode, layer
from urushi.material.layer import layer_texels
from urushi.nets.architecture import FIXED
from urushi.nets.weights import Model
from urushi.walk import conductor, dielectric

#: Texels per side of the textures that are layered; the times are extrapolated to `TEXTURE` texels
#: per side as a constant plus a time per texel.
TILES, TEXTURE = (128, 256), 1024

GOLD, TOP = conductor(0.2, (0.98, 0.77, 0.34)), dielectric(0.05, 1.5)

#: Pairs of directions in the measurement of evaluations per second.
PAIRS = 1 << 16


def parameters(model: Model) -> dict[str, int]:
    """Number of trained parameters by network."""
    counts: dict[str, int] = {}
    for name, array in model.params.items():
        if name not in FIXED:
            part = name.split(".", 1)[0]
            counts[part] = counts.get(part, 0) + array.size
    return counts


def seconds(model: Model) -> dict[str, float]:
    """Median times [s] of the public operations on NumPy, on this machine at its present load."""
    single = {name: _median(run, 15) for name, run in single_operations(model).items()}
    small, large = (
        {name: _median(run, 3) for name, run in texture_operations(model, side).items()}
        for side in TILES
    )
    beyond = (TEXTURE**2 - TILES[1] ** 2) / (TILES[1] ** 2 - TILES[0] ** 2)
    textures = {
        f"layer a {TEXTURE}² RGB texture, {name} (from {TILES[1]}²)": large[name]
        + beyond * (large[name] - small[name])
        for name in large
    }
    bottom = encode(GOLD, model)
    wi, wo = np.random.default_rng(0).normal(size=(2, PAIRS, 3))
    wi, wo = (np.abs(w) / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    evaluations = 1e6 / PAIRS * _median(lambda: bottom.f(wi, wo), 3)
    return {**single, **textures, "a million RGB evaluations": evaluations}


def single_operations(model: Model) -> dict[str, Callable[[], object]]:
    """Operations on one material, by name."""
    bottom = encode(GOLD, model)
    return {
        "encode one RGB material": lambda: encode(GOLD, model),
        "layer one RGB material": lambda: layer(TOP, bottom, albedo=0.8, sigma_t=(0.2, 1.0, 3.0)),
    }


def texture_operations(model: Model, side: int) -> dict[str, Callable[[], object]]:
    """Layering of side x side RGB texels, by name; coats vary in every parameter and channel."""
    rng = np.random.default_rng(0)
    shape = side, side, 3
    coat: dict[str, Any] = {
        "alpha": rng.uniform(0.05, 0.5, shape),
        "eta": rng.uniform(1.3, 1.7, shape),
        "albedo": rng.uniform(0, 1, shape),
        "sigma_t": rng.uniform(0, 3, shape),
        "g": rng.uniform(-0.5, 0.5, shape),
    }
    grey = {name: values[..., :1] for name, values in coat.items()}
    one = encode(GOLD, model).anchors
    many = np.broadcast_to(one, (side, side, *one.shape)).copy()
    return {
        "all varying": lambda: layer_texels(model, many, **coat),
        "one bottom": lambda: layer_texels(model, one, **coat),
        "grey coat": lambda: layer_texels(model, many, **grey),
    }


def _median(operation: Callable[[], object], runs: int) -> float:
    """Median time [s] of an operation over `runs`, after one run that is not counted."""
    operation()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        operation()
        times.append(time.perf_counter() - start)
    return statistics.median(times)
