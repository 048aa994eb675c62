"""The scene "shoe": a pair of loafers, burnished leather under a finish, relief by normal maps."""

from typing import Any

import mitsuba as mi
import numpy as np

from urushi.scenes import leather, shoe_shape, stage
from urushi.scenes.mesh import grid
from urushi.scenes.stage import Folder, Light, Options, rgb

#: Texels around the upper; half as many from the sole to the collar.
TEXELS = 1024


def shoe(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene, its files in `folder`."""
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.42, 0.46, 0.55),
            horizon=(0.30, 0.275, 0.25),
            ground=(0.12, 0.11, 0.10),
            lights=[
                Light((-3.7, -4.5, 5.0), (0.34, 0.30), (9.5, 9.0, 8.2)),
                Light((2.9, 3.6, 2.9), (0.55, 0.20), (7.5, 8.1, 9.4)),
            ],
        ),
        "table": stage.table(5.0, 0.34, 0.30, 0.25),
    }
    transform = mi.ScalarTransform4d()
    right = transform.translate([0.10, -0.55, 0]) @ transform.rotate([0, 0, 1], -22)
    left = transform.translate([0.55, 0.95, 0]) @ transform.rotate([0, 0, 1], -48)
    for side, placed in (("right", right), ("left", left)):
        parts |= _one(folder, options, side, placed)
    view = stage.camera(options, (0.6, -7.2, 3.3), (0.3, 0, 0.5), 29)
    return stage.scene(view, parts)


def _one(folder: Folder, options: Options, side: str, placed: Any) -> dict[str, Any]:
    """The parts of one shoe; the left one is the right one's mirror image in y."""

    def surface(points: np.ndarray) -> np.ndarray:
        return points if side == "right" else points[:, ::-1] * [1, -1, 1]

    def image(texels: np.ndarray) -> np.ndarray:
        return texels if side == "right" else texels[:, ::-1]

    texels = options.texels(TEXELS)
    u = (np.arange(texels) + 0.5) / texels
    v = (np.arange(texels // 2) + 0.5) / (texels // 2)
    albedo, depth, height = leather.upper(u[None, :], v[:, None])
    relief = leather.relief(surface(shoe_shape.upper(u[None, :], v[:, None])), image(height))
    finish = options.coated(
        stage.diffuse(0.34, 0.15, 0.07),
        alpha=0.13,
        int_ior=1.5,
        albedo=folder.texture(f"{side}-albedo", image(albedo)),
        sigma_t=folder.texture(f"{side}-depth", image(depth)),
    )
    upper = {
        "type": "normalmap",
        "normalmap": folder.texture(f"{side}-relief", relief),
        "bsdf": finish,
    }
    edge = options.coated(
        stage.diffuse(0.10, 0.05, 0.03),
        alpha=0.10,
        int_ior=1.5,
        albedo=rgb(0.35, 0.15, 0.08),
        sigma_t=rgb(1.0, 1.4, 1.6),
    )
    leathers = {
        "upper": upper,
        "lining": stage.diffuse(0.55, 0.36, 0.20),
        "collar": edge,
        "sole": edge,
        "heel": edge,
    }
    parts = {}
    around = np.linspace(0, 1, 385)
    for name, rows in shoe_shape.SHAPES.items():
        points = rows(around[None, :], np.linspace(0, 1, 129)[:, None])
        parts[f"{side}-{name}"] = folder.mesh(
            f"{side}-{name}", grid(surface(points), closed=True)
        ) | {"to_world": placed, "bsdf": leathers[name]}
    return parts
