"""Tea caddy: a lacquered tea caddy on a dark table between softboxes."""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import stage
from gallery.mesh import Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, conductor, diffuse, rgb
from urushi.app.render import DEMO_SCENE

#: Rows of the pattern's texture.
TEXTURE_HEIGHT = 384

#: Rotation of the caddy about its axis, which turns the blossoms to the camera [degrees].
TURN = 105.0


def caddy(folder: Folder, options: Options) -> dict[str, Any]:
    """A scene for `mi.load_dict`; see `gallery.export`."""
    mesh = folder.mesh("natsume", lathe(natsume(), 128, 192))
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": _camera(options),
        "sky": _sky(folder),
        **_softboxes(),
        "table": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4d().scale(40),
            "bsdf": {
                "type": "roughplastic",
                "diffuse_reflectance": rgb(0.032, 0.030, 0.030),
                "alpha": 0.12,
            },
        },
        "caddy": {
            **mesh,
            "to_world": mi.ScalarTransform4d().rotate([0, 0, 1], TURN),
            "bsdf": coat(folder, options),
        },
    }


def coat(folder: Folder, options: Options) -> dict[str, Any]:
    """The lacquer: dark and thick, thin over the pattern so that the gold below shines through.

    Albedo and optical depth are those of the package: maki-e of cherry blossoms over a stream.
    """
    rows = options.texels(TEXTURE_HEIGHT)
    medium = {}
    for name, parameter in (("albedo", "albedo"), ("depth", "sigma_t")):
        values = mi.Bitmap(str(DEMO_SCENE.with_name(f"{name}.exr")))
        if rows != TEXTURE_HEIGHT:  # its filter swings beyond the values that it averages
            values = values.resample([2 * rows, rows], clamp=(0.0, np.array(values).max()))
        # Between gold and lacquer f is far from linear in sigma_t.
        medium[parameter] = folder.texture(name, np.array(values)) | {"filter_type": "nearest"}
    return options.coated(conductor("Au", 0.22), alpha=0.05, int_ior=1.5, g=0.0, **medium)


def _camera(options: Options) -> dict[str, Any]:
    return stage.camera(options, origin=[0, -4.2, 1.75], target=[0, 0, 0.47], fov=21)


def _sky(folder: Folder) -> dict[str, Any]:
    """A dim dusk: cool overhead, warm at the horizon, dark below."""
    elevation = np.linspace(1, -1, 33)[:, None, None]
    zenith, horizon = np.array([0.16, 0.20, 0.27]), np.array([0.42, 0.33, 0.25])
    colour = horizon + (zenith - horizon) * np.clip(elevation, 0, 1) ** 0.5
    return folder.environment("sky", np.broadcast_to(colour * (elevation > -0.1), (33, 64, 3)))


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
        "to_world": mi.ScalarTransform4d().look_at(origin=origin, target=target, up=[0, 0, 1])
        @ mi.ScalarTransform4d().scale([*size, 1]),
        "emitter": {"type": "area", "radiance": rgb(*radiance)},
        "bsdf": diffuse(0.0, 0.0, 0.0),
    }


def natsume() -> Profile:
    """A tea caddy about 1.06 high and 1 wide: a swelling body under a gently domed lid."""
    return Profile(np.array(NATSUME))


# The lid's rim is the fine groove a third of the way down. Points close together bend sharply.
NATSUME = [
    (0.00, 0.035), (0.15, 0.035), (0.270, 0.032), (0.300, 0.010), (0.330, 0.000), (0.375, 0.030),
    (0.425, 0.120), (0.470, 0.260), (0.497, 0.420), (0.503, 0.560), (0.502, 0.640),
    (0.501, 0.672), (0.498, 0.684), (0.491, 0.690), (0.491, 0.692), (0.498, 0.698),
    (0.501, 0.710), (0.500, 0.760), (0.492, 0.850), (0.470, 0.930), (0.420, 0.990),
    (0.330, 1.028), (0.200, 1.050), (0.100, 1.056), (0.000, 1.058),
]  # fmt: skip
