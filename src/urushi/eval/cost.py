"""Sizes and times of networks: reported, not judged."""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.material import encode, layer
from urushi.material.texture import layer_texels
from urushi.nets.architecture import FIXED
from urushi.nets.weights import Model
from urushi.reference import conductor, dielectric

#: A texture of this many texels a side is layered, and its time scaled to `TEXTURE`.
TILE, TEXTURE = 128, 1024

#: Pairs of directions in the measurement of evaluations a second.
PAIRS = 1 << 16


def parameters(model: Model) -> dict[str, int]:
    """Trained numbers by network."""
    counts: dict[str, int] = {}
    for name, array in model.params.items():
        if name not in FIXED:
            part = name.split(".", 1)[0]
            counts[part] = counts.get(part, 0) + array.size
    return counts


def seconds(model: Model) -> dict[str, float]:
    """Median times of the public operations on NumPy, on this machine under its present load."""
    gold = conductor(0.2, (0.98, 0.77, 0.34))
    top = dielectric(0.05, 1.5)
    bottom = encode(gold, model)
    rng = np.random.default_rng(0)
    texture = np.repeat(bottom.latents[None], TILE * TILE, axis=0).reshape(TILE, TILE, 3, -1)
    coat: dict[str, Any] = {
        "alpha": rng.uniform(0.05, 0.5, (TILE, TILE, 1)),
        "eta": 1.5,
        "albedo": rng.uniform(0, 1, (TILE, TILE, 3)),
        "sigma_t": rng.uniform(0, 3, (TILE, TILE, 3)),
        "g": 0.0,
    }
    wi, wo = rng.normal(size=(2, PAIRS, 3))
    wi, wo = (np.abs(w) / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    tiles = (TEXTURE // TILE) ** 2
    return {
        "encode one RGB material": _median(lambda: encode(gold, model), 15),
        "layer one RGB material": _median(
            lambda: layer(top, bottom, albedo=0.8, sigma_t=(0.2, 1.0, 3.0)), 15
        ),
        f"layer a {TEXTURE}² RGB texture (from {TILE}²)": tiles
        * _median(lambda: layer_texels(model, texture, **coat), 3),
        "a million RGB evaluations": 1e6 / PAIRS * _median(lambda: bottom.f(wi, wo), 3),
    }


def _median(operation: Callable[[], object], runs: int) -> float:
    """Median time of an operation, after one that is not counted."""
    operation()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        operation()
        times.append(time.perf_counter() - start)
    return statistics.median(times)
