"""A sphere of a material with textures or without them, and its renders, for timings."""

import drjit as dr
import mitsuba as mi
import numpy as np
from benchmarks import timing
from benchmarks.scenes import PRINCIPLED, coat

#: Texels along a side of a texture.
TEXELS = 64

#: Numbers of textures: of few parameters, and of all.
FEW, ALL = 3, 6


def texture(low: float, high: float, channels: int, seed: int, side: int = TEXELS) -> dict:
    """A texture of uniform random texels."""
    texels = np.random.default_rng(seed).uniform(low, high, (side, side, channels))
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels.astype(np.float32)), "raw": True}


def value(low: float, high: float, channels: int, seed: int) -> dict | float:
    """One value from the same range."""
    numbers = np.random.default_rng(seed).uniform(low, high, channels).tolist()
    return {"type": "rgb", "value": numbers} if channels == 3 else numbers[0]


def material(plugin: str, textures: int) -> dict:
    """The sphere's BSDF; plugin: `PRINCIPLED`, or as of `scenes.coat`.

    textures: none; `FEW`: the colour, the width of the coat and the roughness below; more: of all
    parameters.
    """
    first = texture if textures else value
    other = texture if textures > FEW else value
    if plugin == PRINCIPLED:
        return {
            "type": PRINCIPLED,
            "base_color": first(0.2, 0.95, 3, 1),
            "roughness": first(0.1, 0.6, 1, 2),
            "metallic": other(0, 1, 1, 3),
            "clearcoat": other(0.1, 1, 1, 4),
            "clearcoat_gloss": first(0.3, 0.9, 1, 5),
        }
    bottom = {"type": "roughconductor", "distribution": "ggx", "alpha": first(0.05, 0.4, 1, 1)}
    return coat(plugin) | {
        "alpha": first(0.02, 0.3, 1, 3),
        "albedo": first(0.2, 0.95, 3, 4),
        "sigma_t": other(0.1, 2, 3, 5),
        "g": other(-0.3, 0.6, 3, 6),
        "bottom": bottom | {"specular_reflectance": other(0.3, 0.95, 3, 2)},
    }


def scene(bsdf: dict, side: int) -> "mi.Scene":
    """A sphere, which fills the picture, under an environment map."""
    sky = np.random.default_rng(0).uniform(0.5, 1.5, (64, 128, 1)).repeat(3, axis=2)
    sky[10:16, 30:40] = 20
    look = mi.ScalarTransform4f().look_at([0, 0, 4.2], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": {"type": "perspective", "fov": 30, "to_world": look, "film": film},
            "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky.astype(np.float32))},
            "sphere": {"type": "sphere", "bsdf": bsdf},
        }
    )


def seconds(loaded: "mi.Scene", spp: int, seed: int) -> float:
    """CPU time of one render [s]."""

    def render() -> None:
        dr.eval(mi.render(loaded, spp=spp, seed=seed))
        dr.sync_thread()

    return timing.seconds(render)
