"""Mip pyramids against averages of BRDFs: `python -m benchmarks.quality.mipmap`.

The textures are coats over a conductor whose parameters are noise (no two texels alike) or a smooth
pattern. For each level of the pyramid, prints the error E (docs/conventions.md) against the average
of the BRDFs of the texels below, as a mean over the level's texels:

- plain: averages of codes, as in Fan et al. (2022);
- Urushi: averages weighted by light (`urushi/textures/mip_pyramid.py`).

Then prints the CPU time of all levels of a texture of noise of 2048² texels (`--side` sets another
size).
"""

import argparse
import time

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.error_metrics import stack_error
from urushi.material import encode
from urushi.material.layer import layer_texels
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.textures import mip_pyramid
from urushi.textures.mip_pyramid import coarse_levels
from urushi.walk import conductor

SIDE, LEVELS, PAIRS = 32, 4, 128

GOLD = conductor(0.2, (0.98, 0.77, 0.34))

KINDS = {
    "alpha, smooth": ("alpha", True),
    "alpha, noise": ("alpha", False),
    "albedo, smooth": ("albedo", True),
    "albedo, noise": ("albedo", False),
    "sigma_t, noise": ("sigma_t", False),
    "all, smooth": ("alpha albedo sigma_t", True),
    "all, noise": ("alpha albedo sigma_t", False),
}


def pattern(rng: np.random.Generator, smooth: bool) -> np.ndarray:
    """Numbers (SIDE, SIDE) in [0, 1], approximately uniformly distributed."""
    if not smooth:
        return rng.random((SIDE, SIDE))
    angle = 2 * np.pi * np.arange(SIDE) / SIDE
    x, y = np.meshgrid(angle, angle)
    waves = [np.sin(k * x + m * y + rng.uniform(0, 6)) for k in (1, 2, 3) for m in (-2, 1, 3)]
    order = np.sum(waves, axis=0).ravel().argsort().argsort()
    return (order / order.max()).reshape(SIDE, SIDE)


def textured(model: Model, kind: str) -> np.ndarray:
    """Codes (SIDE, SIDE, 3, size) of a textured coat."""
    rng = np.random.default_rng(0)
    names, smooth = KINDS[kind]
    coat = {"alpha": 0.1, "albedo": 0.8, "sigma_t": 1.0}
    ranges = {
        "alpha": lambda u: 0.02 * 25.0**u,
        "albedo": lambda u: u,
        "sigma_t": lambda u: 3 * u,
    }
    for name in names.split():
        coat[name] = ranges[name](pattern(rng, smooth))[..., None]
    return layer_texels(model, encode(GOLD, model).latents, CoatParameters(eta=1.5, g=0.0, **coat))


def cosine_pairs(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """PAIRS pairs of directions (PAIRS, 3), both of cosine density."""
    u, turn = rng.random((2, PAIRS)), 2 * np.pi * rng.random((2, PAIRS))
    r = np.sqrt(u)
    w = np.stack([r * np.cos(turn), r * np.sin(turn), np.sqrt(1 - u)], axis=-1)
    return w[0].astype(np.float32), w[1].astype(np.float32)


def pyramid(model: Model, codes: np.ndarray) -> list[np.ndarray]:
    """The coarser levels of codes (SIDE, SIDE, 3, size)."""
    sizes = mip_pyramid.level_sizes(*codes.shape[1::-1])
    first = codes.reshape(-1, *codes.shape[2:])
    coarse = coarse_levels(model, *sizes[0], first.__getitem__)
    parts = np.split(coarse, np.cumsum([w * h for w, h in sizes[1:]]))
    return [
        part.reshape(height, width, *part.shape[1:])
        for part, (width, height) in zip(parts, sizes[1:], strict=False)
    ]


def errors(model: Model, kind: str) -> list[tuple[float, ...]]:
    """E of every level: plain averages and Urushi's levels."""
    wi, wo = cosine_pairs(np.random.default_rng(1))

    def values(codes: np.ndarray) -> np.ndarray:
        rows = codes.reshape(-1, codes.shape[-1])
        parts = np.split(rows, 3)
        f = np.concatenate([model.networks.f(z[:, None], wi, wo) for z in parts])
        return f.reshape(*codes.shape[:-1], -1)

    plain = textured(model, kind)
    f, weighted = values(plain), pyramid(model, plain)
    result = []
    for level in range(LEVELS):
        height = SIDE >> level
        f, plain = (
            mip_pyramid.half_resolution(f, 0, height),
            mip_pyramid.half_resolution(plain, 0, height),
        )
        result.append(
            tuple(
                float(stack_error(values(z), f, wi[:, 2], wo[:, 2]).mean())
                for z in (plain, weighted[level])
            )
        )
    return result


def seconds(model: Model, side: int) -> float:
    """CPU time of all levels of a texture of noise."""
    codes = textured(model, "all, noise").reshape(-1, 3, model.arch.latent)
    choice = np.random.default_rng(2).integers(len(codes), size=side * side)
    first = codes[choice].astype(np.float16)
    start = time.process_time()
    coarse_levels(model, side, side, first.__getitem__)
    return time.process_time() - start


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.mipmap",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("--side", type=int, default=2048, help="side of the timed texture [texels]")
    options = parser.parse_args()
    model = weights.find(options.weights)
    print(f"{'E [%]':18}{'level':>7}{'plain':>9}{'Urushi':>9}")
    for kind in KINDS:
        for level, row in enumerate(errors(model, kind), 1):
            name = kind if level == 1 else ""
            print(f"{name:18}{level:7}" + "".join(f"{100 * value:9.2f}" for value in row))
    print(f"levels of {options.side}²: {seconds(model, options.side):.1f} s of CPU time")


if __name__ == "__main__":
    main()
