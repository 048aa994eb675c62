"""The demo's scene: the lacquered caddy on a dark table between softboxes."""

from typing import Any

import mitsuba as mi
import numpy as np

from urushi.app.demo import geometry, pattern

#: Rows of the pattern's texture.
TEXTURE_HEIGHT = 512

#: The lacquer's optical depth and albedo over plain ground, and where the gold shows.
LACQUER_DEPTH, GOLD_DEPTH = np.array([2.2, 5.0, 6.0]), np.array([0.02, 0.08, 0.25])
LACQUER_ALBEDO, GOLD_ALBEDO = np.array([0.55, 0.10, 0.05]), np.array([0.9, 0.7, 0.5])

#: Turn of the caddy that shows the blossoms to the camera [degrees].
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
                "diffuse_reflectance": {"type": "rgb", "value": [0.075, 0.068, 0.062]},
                "alpha": 0.25,
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
    gold = pattern.gold(geometry.natsume(), TEXTURE_HEIGHT)[..., None]
    depth = LACQUER_DEPTH * (GOLD_DEPTH / LACQUER_DEPTH) ** gold  # layers thin by ratios
    albedo = LACQUER_ALBEDO + (GOLD_ALBEDO - LACQUER_ALBEDO) * gold
    return {
        "type": bsdf,
        "alpha": 0.05,
        "int_ior": 1.5,
        "albedo": _texture(albedo),
        "sigma_t": _texture(depth),
        "g": 0.0,
        "bottom": {"type": "roughconductor", "material": "Au", "alpha": 0.22},
    }


def _texture(values: np.ndarray) -> dict[str, Any]:
    """An (H, W, 3) array as a texture, taken as it is."""
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
