"""The demo's scene: a lacquered tea caddy on a dark table between softboxes."""

from typing import Any

import mitsuba as mi
import numpy as np

from urushi.scenes import caddy_pattern
from urushi.scenes.mesh import Profile

#: Rows of the pattern's texture.
TEXTURE_HEIGHT = 384

#: Optical depth and albedo of the black lacquer, of the red, and of the thin coat over the gold.
BLACK = np.array([4.0, 5.0, 6.0]), np.array([0.30, 0.05, 0.03])
RED = np.array([3.0, 6.0, 6.0]), np.array([0.85, 0.14, 0.05])
GOLD = np.array([0.02, 0.05, 0.15]), np.array([0.9, 0.8, 0.6])

#: Rotation of the caddy about its axis, which turns the blossoms to the camera [degrees].
TURN = 105.0


def scene(bsdf: str, mesh: str, *, width: int = 400, height: int = 400) -> dict[str, Any]:
    """Describe the scene, ready for `mi.load_dict`.

    Args:
        bsdf: the plugin of the caddy's coat: "layered" or "neural_layered".
        mesh: path of the caddy's PLY file.
        width, height: pixels of the film.
    """
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": _camera(width, height),
        "sky": _sky(),
        **_softboxes(),
        "table": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().scale(40),
            "bsdf": {
                "type": "roughplastic",
                "diffuse_reflectance": {"type": "rgb", "value": [0.032, 0.030, 0.030]},
                "alpha": 0.12,
            },
        },
        "caddy": {
            "type": "ply",
            "filename": mesh,
            "to_world": mi.ScalarTransform4f().rotate([0, 0, 1], TURN),
            "bsdf": coat(bsdf),
        },
    }


def coat(bsdf: str) -> dict[str, Any]:
    """The lacquer: dark and thick, thin over the pattern so that the gold below shines through."""
    depth, albedo = lacquer()
    return {
        "type": bsdf,
        "alpha": 0.05,
        "int_ior": 1.5,
        "albedo": _texture(albedo),
        "sigma_t": _texture(depth),
        "g": 0.0,
        "bottom": {
            "type": "roughconductor",
            "distribution": "ggx",
            "material": "Au",
            "alpha": 0.22,
        },
    }


def lacquer() -> tuple[np.ndarray, np.ndarray]:
    """Optical depth and albedo of the coat, (H, W, 3) each: black to red to black, then gold.

    Depths are interpolated in their logarithms.
    """
    profile = natsume()
    gold = caddy_pattern.gold(profile, TEXTURE_HEIGHT)[..., None]
    height = profile((np.arange(TEXTURE_HEIGHT) + 0.5) / TEXTURE_HEIGHT)[0][:, 1]
    red = np.exp(-(((height - 0.42) / 0.30) ** 2))[:, None, None]  # a red band between black ones
    depth = np.exp(_blend(gold, _blend(red, *np.log([BLACK[0], RED[0]])), np.log(GOLD[0])))
    return depth, _blend(gold, _blend(red, BLACK[1], RED[1]), GOLD[1])


def _blend(amount: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return first + (second - first) * amount


def _texture(values: np.ndarray) -> dict[str, Any]:
    """An (H, W, 3) array as a texture without colour conversion."""
    return {
        "type": "bitmap",
        "data": mi.TensorXf(values.astype(np.float32)),
        "raw": True,
    }


def _camera(width: int, height: int) -> dict[str, Any]:
    return {
        "type": "perspective",
        "fov": 21,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=[0, -4.2, 1.75], target=[0, 0, 0.47], up=[0, 0, 1]
        ),
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "gaussian"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent"},
    }


def _sky() -> dict[str, Any]:
    """A dim dusk: cool overhead, warm at the horizon, dark below."""
    elevation = np.linspace(1, -1, 33)[:, None, None]
    zenith, horizon = np.array([0.16, 0.20, 0.27]), np.array([0.42, 0.33, 0.25])
    colour = horizon + (zenith - horizon) * np.clip(elevation, 0, 1) ** 0.5
    colour = np.broadcast_to(colour * (elevation > -0.1), (33, 64, 3))
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(colour, dtype=np.float32)),
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
    }


def _softboxes() -> dict[str, Any]:
    """A large key light, a strip from behind for the edge, and a low fill."""
    return {
        "key": _softbox([-3.4, -2.4, 3.2], [0, 0, 0.5], (0.9, 1.3), [22.0, 20.4, 18.0]),
        "edge": _softbox([3.0, 1.2, 1.6], [0, 0, 0.5], (0.35, 1.5), [14.0, 16.0, 19.0]),
        "back": _softbox([-0.4, 3.4, 3.4], [0, 0, 0.9], (1.5, 0.5), [9.0, 8.8, 8.5]),
        "front": _softbox([1.8, -5.0, 3.6], [0, 0, 0.5], (1.8, 1.0), [5.0, 4.6, 4.0]),
    }


def _softbox(
    origin: list[float], target: list[float], size: tuple[float, float], radiance: list[float]
) -> dict[str, Any]:
    """A one-sided rectangle of half sizes `size`, facing `target`."""
    return {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 0, 1])
        @ mi.ScalarTransform4f().scale([*size, 1]),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
    }


def natsume() -> Profile:
    """A tea caddy about 1.06 high and 1 wide: a swelling body under a gently domed lid."""
    return Profile(np.array(NATSUME))


# The lid's rim is the fine groove a third of the way down. Points close together bend sharply.
NATSUME = [
    (0.00, 0.035),
    (0.15, 0.035),
    (0.270, 0.032),
    (0.300, 0.010),
    (0.330, 0.000),
    (0.375, 0.030),
    (0.425, 0.120),
    (0.470, 0.260),
    (0.497, 0.420),
    (0.503, 0.560),
    (0.502, 0.640),
    (0.501, 0.672),
    (0.498, 0.684),
    (0.491, 0.690),
    (0.491, 0.692),
    (0.498, 0.698),
    (0.501, 0.710),
    (0.500, 0.760),
    (0.492, 0.850),
    (0.470, 0.930),
    (0.420, 0.990),
    (0.330, 1.028),
    (0.200, 1.050),
    (0.100, 1.056),
    (0.000, 1.058),
]
