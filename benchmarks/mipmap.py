"""Mip maps against averages of BRDFs: `python -m benchmarks.mipmap`; a minute or two.

For coats over a conductor whose parameters are noise (no two texels alike), a smooth pattern, or a
checkerboard, prints the error E (docs/conventions.md) of each level of the mip map against the
average of the BRDFs of the texels that it stands for, mean over the level's texels:

- plain: averages of codes, as in Fan et al. (2022);
- Urushi: averages of codes that keep the light (`urushi/material/brightness.py`);
- encoded: the code that the encoder makes of the averaged values, which costs 192 evaluations of
  every texel.
"""

import argparse

import numpy as np

from urushi.data.metrics import stack_error
from urushi.material import brightness, encode, mipmap
from urushi.material.texture import encode_texels, layer_texels
from urushi.nets import shipped
from urushi.nets.weights import Model
from urushi.reference import conductor

SIDE, LEVELS, PAIRS = 32, 4, 256
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
    """Numbers (SIDE, SIDE) in [0, 1], about uniform."""
    if not smooth:
        return rng.random((SIDE, SIDE))
    angle = 2 * np.pi * np.arange(SIDE) / SIDE
    x, y = np.meshgrid(angle, angle)
    waves = [np.sin(k * x + m * y + rng.uniform(0, 6)) for k in (1, 2, 3) for m in (-2, 1, 3)]
    order = np.sum(waves, axis=0).ravel().argsort().argsort()
    return (order / order.max()).reshape(SIDE, SIDE)


def textured(model: Model, kind: str) -> np.ndarray:
    """Codes (SIDE, SIDE, 3, size) of a coat."""
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
    return layer_texels(model, encode(GOLD, model).latents, eta=1.5, g=0.0, **coat)


def cosine_pairs(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (PAIRS, 3) that both have cosine density."""
    u, turn = rng.random((2, PAIRS)), 2 * np.pi * rng.random((2, PAIRS))
    r = np.sqrt(u)
    w = np.stack([r * np.cos(turn), r * np.sin(turn), np.sqrt(1 - u)], axis=-1)
    return w[0].astype(np.float32), w[1].astype(np.float32)


def errors(model: Model, kind: str) -> list[tuple[float, float, float]]:
    """E of every level: of plain averages, of Urushi's, and of encoded average values."""
    wi, wo = cosine_pairs(np.random.default_rng(1))
    probes = model.networks.pairs()

    def values(codes: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        rows = codes.reshape(-1, codes.shape[-1])
        f = np.concatenate([model.networks.f(z[:, None], wi, wo) for z in np.split(rows, 3)])
        return f.reshape(*codes.shape[:-1], -1)

    codes = textured(model, kind)
    rows = codes.reshape(-1, codes.shape[-1])
    light = brightness.fitted(model, lambda index: rows[index], len(rows))
    plain = ours = codes
    f, probed = values(codes, wi, wo), values(codes, *probes)
    result = []
    for level in range(LEVELS):
        height = SIDE >> level
        f, probed = mipmap.halved(f, 0, height), mipmap.halved(probed, 0, height)
        plain = mipmap.halved(plain, 0, height)
        ours = mipmap.coarser(ours, 0, height, light)
        encoded = encode_texels(model, probed)
        result.append(
            tuple(
                float(stack_error(values(z, wi, wo), f, wi[:, 2], wo[:, 2]).mean())
                for z in (plain, ours, encoded)
            )
        )
    return result


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mipmap", description=__doc__)
    parser.add_argument("--weights", default="base", help="base, small, or a weights file")
    model = shipped.find(parser.parse_args().weights)
    print(f"{'E [%]':18}{'level':>7}{'plain':>9}{'Urushi':>9}{'encoded':>9}")
    for kind in KINDS:
        for level, row in enumerate(errors(model, kind), 1):
            name = kind if level == 1 else ""
            print(f"{name:18}{level:7}" + "".join(f"{100 * value:9.2f}" for value in row))


if __name__ == "__main__":
    main()
