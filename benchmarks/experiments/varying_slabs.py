"""Slabs with textures, against constant ones of the values between texels: `neural_layered`."""

import time
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.experiment import Experiment, Found, Options
from benchmarks.showing import table
from benchmarks.timing import evaluation
from gallery.stage import rgb

import urushi  # noqa: F401  # registers the plugins
from urushi.core.direction_sets import cosine_pairs

PAIRS, PLACES, SEED = 1000, 12, 2
PAPER = {"type": "neural_layered", "alpha": 0.3, "int_ior": 1.4}
PAPER |= {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}
GLASS = {"base": {"type": "dielectric", "int_ior": 1.5}}
COLOURS = ((0.02, 0.5, 0.99), (0.9, 0.1, 0.6))

#: Slabs, and the least and the largest values of their textures.
SLABS: dict[str, tuple[dict[str, Any], dict[str, tuple]]] = {
    "albedo, a colour": (PAPER, {"albedo": COLOURS}),
    "sigma_t, 0 to 8": (PAPER, {"sigma_t": (0.0, 8.0)}),
    "alpha, 0.01 to 1": (PAPER, {"alpha": (0.01, 1.0)}),
    "g, −0.9 to 0.9": (PAPER, {"g": (-0.9, 0.9)}),
    "albedo, a colour; sigma_t, 0 to 8": (PAPER, {"albedo": COLOURS, "sigma_t": (0.0, 8.0)}),
    "alpha, 0.05 to 0.5; sigma_t, 0 to 4; on glass": (
        PAPER | GLASS,
        {"alpha": (0.05, 0.5), "sigma_t": (0.0, 4.0)},
    ),
    "alpha, albedo and sigma_t": (
        PAPER,
        {"alpha": (0.05, 0.5), "albedo": (0.05, 0.99), "sigma_t": (0.0, 6.0)},
    ),
}

#: Shares of the largest value at four texels: along u, along v, and their product.
SHARES = np.array([[[0, 1], [0, 1]], [[0, 0], [1, 1]], [[0, 0], [0, 1]]])


def between(ends: tuple, share: np.ndarray) -> np.ndarray:
    """Values (..., C) between the least and the largest ones."""
    low, high = (np.atleast_1d(np.array(x, float)) for x in ends)
    return low + np.asarray(share)[..., None] * (high - low)


def texture(ends: tuple, shares: np.ndarray) -> dict[str, Any]:
    texels = np.ascontiguousarray(between(ends, shares), np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True}


def measure(case: tuple[dict[str, Any], dict[str, tuple]], options: Options) -> Found:
    """CPU seconds of loading, and E (places, 2) of reflected and of transmitted light."""
    slab, ends = case
    textures = {k: texture(x, y) for (k, x), y in zip(ends.items(), SHARES, strict=False)}
    start = time.process_time()
    textured = mi.load_dict(slab | textures)
    seconds = time.process_time() - start
    rng, errors = np.random.default_rng(SEED), []
    wi, wo = cosine_pairs(rng, PAIRS)
    for u, v in rng.random((options.count(PLACES, 2), 2)):
        constants: dict[str, Any] = {}
        for (name, x), share in zip(ends.items(), (u, v, u * v), strict=False):
            value = between(x, share).tolist()
            constants[name] = rgb(*value) if len(value) > 1 else value[0]
        both = textured, mi.load_dict(slab | constants)
        uv = np.tile([0.25 + 0.5 * u, 0.25 + 0.5 * v], (len(wi), 1))
        f_cos = [
            [evaluation(x, wi, wo * [1, 1, side], uv)().numpy() for x in both] for side in (1, -1)
        ]
        errors.append([np.abs(x - y).sum() / y.sum() for x, y in f_cos])
    return {"seconds": seconds, "errors": errors}


def tables(found: Found) -> list[str]:
    """The mean and the largest E of places."""
    head = ["textures", *(f"{x}: mean; largest E" for x in ("reflected", "transmitted"))]
    rows = []
    for name, case in found.items():
        errors = 100 * np.array(case["errors"])
        cells = [f"{x.mean():.2f}; {x.max():.2f} %" for x in errors.T]
        rows.append([name, *cells, f"{case['seconds']:.1f}"])
    return [table([*head, "load [CPU s]"], rows)]


EXPERIMENT = Experiment(
    cases=lambda _: SLABS, measure=measure, tables=tables, pages=("docs/slabs.md",), minutes=4
)
