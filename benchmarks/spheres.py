"""A sphere in a small studio, rendered by Mitsuba, for comparisons side by side and for timings."""

import gc
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks import timing
from benchmarks.scenes import PRINCIPLED, coat
from benchmarks.sphere import SKY
from gallery import stage

LAMPS = (
    *(stage.Light((side, -0.6, 0.9), (0.3, 0.3), (9.0, 9.0, 9.0)) for side in (-1.0, 1.0)),
    stage.Light((0.0, -1.0, 0.15), (0.08, 0.08), (12.0, 12.0, 12.0)),
)
#: Texels along a side of a texture.
TEXELS = 64

#: Numbers of textures: of few parameters, and of all.
FEW, ALL = 3, 6


def texture(side: int, low: float, high: float, channels: int, seed: int) -> dict:
    """A texture of uniform random texels."""
    texels = np.random.default_rng(seed).uniform(low, high, (side, side, channels))
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels.astype(np.float32)), "raw": True}


def value(low: float, high: float, channels: int, seed: int) -> dict | float:
    """One value from the same range."""
    numbers = np.random.default_rng(seed).uniform(low, high, channels).tolist()
    return {"type": "rgb", "value": numbers} if channels == 3 else numbers[0]


def material(plugin: str, textures: int, side: int = TEXELS, brushed: bool = False) -> dict:
    """The sphere's BSDF; plugin: `PRINCIPLED`, or as of `scenes.coat`.

    textures: none; `FEW`: the colour, the width of the coat and the roughness below; more: of all
    parameters. side: of the textures, in texels. brushed: whether the metal has two widths.
    """
    textured = partial(texture, side)
    first, other = (textured if textures > least else value for least in (0, FEW))
    if plugin == PRINCIPLED:
        return {
            "type": PRINCIPLED,
            "base_color": first(0.2, 0.95, 3, 1),
            "roughness": first(0.1, 0.6, 1, 2),
            "metallic": other(0, 1, 1, 3),
            "clearcoat": other(0.1, 1, 1, 4),
            "clearcoat_gloss": first(0.3, 0.9, 1, 5),
            **({"anisotropic": 0.6} if brushed else {}),
        }
    width = first(0.05, 0.4, 1, 1)
    widths = {"alpha_u": width, "alpha_v": 0.3} if brushed else {"alpha": width}
    bottom = {"type": "roughconductor", "distribution": "ggx"} | widths
    return coat(plugin) | {
        "alpha": first(0.02, 0.3, 1, 3),
        "albedo": first(0.2, 0.95, 3, 4),
        "sigma_t": other(0.1, 2, 3, 5),
        "g": other(-0.3, 0.6, 3, 6),
        "bottom": bottom | {"specular_reflectance": other(0.3, 0.95, 3, 2)},
    }


def described(bsdf: dict[str, Any], size: int, folder: Path) -> dict[str, Any]:
    """A sphere of a described material before a black background, `size` pixels wide and high."""
    look = mi.ScalarTransform4f().look_at([0, -4, 0.6], [0, 0, 0], [0, 0, 1])
    film = {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb"}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3, "hide_emitters": True},
        "sensor": {"type": "perspective", "fov": 30, "to_world": look, "film": film},
        "light": stage.surround(stage.Folder(folder), *SKY, LAMPS),
        "sphere": {"type": "sphere", "bsdf": bsdf},
    }


def scene(bsdf: dict[str, Any], size: int) -> "mi.Scene":
    """The scene of `described`."""
    with TemporaryDirectory() as folder:
        return mi.load_dict(described(bsdf, size, Path(folder)))


def seconds(loaded: "mi.Scene", spp: int, seed: int) -> float:
    """CPU time of one render [s]."""
    return timing.seconds(lambda: mi.render(loaded, spp=spp, seed=seed).numpy())


def renders(
    scenes: Mapping[str, Callable[[], "mi.Scene"]], spp: int
) -> dict[str, tuple[float, float]]:
    """By name, CPU seconds of a render, and those that a first one needs beside, to compile.

    Mitsuba compiles all BSDFs in memory into every kernel: scenes are loaded again for every turn,
    and then released.
    """
    times: dict[str, list[float]] = {name: [] for name in scenes}
    compiling = {}
    for turn in range(3):
        for name, load in scenes.items():
            loaded = load()
            first, *later = (seconds(loaded, spp, seed) for seed in range(3))
            times[name].append(min(later))
            if turn == 0:
                compiling[name] = first - min(later)
            del loaded
            gc.collect()
    return {name: (float(np.median(t)), compiling[name]) for name, t in times.items()}
