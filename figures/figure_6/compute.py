"""Spheres of gold under one coat: both roughnesses, and the medium between them.

    python -m figures.figure_6.compute

Each material is rendered by the networks and by the random walk in one studio, and its E is
measured at pairs of directions. The left half of a sphere is rendered by the networks, the right
half by the walk: an error would show as a seam.
"""

import functools
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

import urushi
from figures import results
from figures.sphere import render
from urushi.core import direction_sets
from urushi.core.error_metrics import stack_error
from urushi.files import atomic_write
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("figure_6")
#: The grid of roughness: GGX widths of the coat (rows) and of the gold (columns).
TOPS, BOTTOMS = (0.05, 0.1, 0.2, 0.4), (0.1, 0.2, 0.35, 0.6)
#: The grid of media: optical depths (rows) and albedos (columns).
DEPTHS, ALBEDOS = (0.25, 0.5, 1.0, 2.0), (0.0, 0.5, 0.9, 1.0)
#: What a grid does not vary.
COAT: dict[str, Any] = {"alpha": 0.1, "eta": 1.5, "sigma_t": 0.25, "albedo": 0.7, "g": 0.0}
BOTTOM, GOLD = 0.2, (1.0, 0.78, 0.34)
#: Pixels of a sphere, samples of a pixel, and pairs and walks for E.
SIZE, SAMPLES, PAIRS, WALKS = 128, 256, 300, 1 << 15
SEED = 6


def materials() -> dict[str, list[list[tuple[dict[str, float], float]]]]:
    """Parameters of the coat and width of the gold, by grid, row and column."""
    roughness = [[({**COAT, "alpha": top}, bottom) for bottom in BOTTOMS] for top in TOPS]
    media = [
        [({**COAT, "sigma_t": depth, "albedo": albedo}, BOTTOM) for albedo in ALBEDOS]
        for depth in DEPTHS
    ]
    return {"roughness": roughness, "media": media}


def main() -> None:
    """Compute what is missing; write results.json and spheres.png."""
    mi.set_variant("llvm_ad_rgb")
    found = {"weights": default_model().fingerprint}
    for name, rows in materials().items():
        flat = [material for row in rows for material in row]
        errors = results.collect(
            PARTS / name,
            {f"error_{i}": functools.partial(error, *material) for i, material in enumerate(flat)},
        )
        found[name] = np.reshape(list(errors.values()), (len(rows), -1, 2)).tolist()
        pictures = np.reshape([sphere(*m) for m in flat], (len(rows), -1, SIZE, SIZE, 3))
        with atomic_write(FOLDER / f"{name}.png") as temporary:
            joined = np.concatenate(np.concatenate(pictures, axis=-3), axis=-2)
            mi.Bitmap(joined.astype(np.float32)).convert(
                mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True
            ).write(str(temporary))
    results.write(FOLDER / "results.json", found)


def error(coat: dict[str, float], bottom: float, walks: int = WALKS) -> list[float]:
    """E of the networks against the walk, and E of one standard error of the walk."""
    rng = np.random.default_rng(SEED)
    wi, wo = direction_sets.cosine_pairs(rng, PAIRS, lowest_cosine=0.02)
    base = urushi.conductor(alpha=bottom, r0=GOLD)
    f, se = urushi.simulate(urushi.coat(base, **coat), wi, wo, walks=walks, seed=SEED)
    top = {name: coat[name] for name in ("alpha", "eta")}
    medium = {name: coat[name] for name in ("sigma_t", "albedo", "g")}
    ours = urushi.layer(urushi.dielectric(**top), base, **medium).f(wi, wo)
    measured = [stack_error(x.T, f.T, wi[:, 2], wo[:, 2]).mean() for x in (ours, f + se)]
    return results.rounded(np.array(measured))


def sphere(coat: dict[str, float], bottom: float) -> np.ndarray:
    """The picture (SIZE, SIZE, 3) of a sphere: networks on the left, the walk on the right."""
    left, right = (_render(name, coat, bottom) for name in ("neural_layered", "layered"))
    return np.concatenate([left[:, : SIZE // 2], right[:, SIZE // 2 :]], axis=1)


def _render(plugin: str, coat: dict[str, float], bottom: float) -> np.ndarray:
    parameters = {name: value for name, value in coat.items() if name != "eta"}
    base = {"type": "roughconductor", "distribution": "ggx", "alpha": bottom, "material": "none"}
    gold = {"specular_reflectance": {"type": "rgb", "value": list(GOLD)}}
    bsdf = {"type": plugin, **parameters, "int_ior": coat["eta"], "ext_ior": 1.0}
    return render(bsdf | {"bottom": {**base, **gold}}, SIZE, SAMPLES, SEED)


if __name__ == "__main__":
    main()
