"""The scene "shoe": a pair of loafers, burnished leather under a finish, relief by normal maps."""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import noise, shoe_shape, stage
from gallery.grids import derivatives, grid
from gallery.options import Options
from gallery.relief import normal_map
from gallery.stage import Folder, Light, rgb

#: Texels around the upper; half as many from the sole to the collar.
TEXELS = 1024

#: The seam around the toe and the two edges of the strap over the instep, in v.
APRON, STRAP = 0.50, (0.70, 0.90)


def shoe(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
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
    albedo, depth, height = leather(u[None, :], v[:, None])
    normals = relief(surface(shoe_shape.upper(u[None, :], v[:, None])), image(height))
    finish = options.coated(
        stage.diffuse(0.34, 0.15, 0.07),
        alpha=0.13,
        int_ior=1.5,
        albedo=folder.texture(f"{side}-albedo", image(albedo)),
        sigma_t=folder.texture(f"{side}-depth", image(depth)),
    )
    upper = {
        "type": "normalmap",
        "normalmap": folder.texture(f"{side}-relief", normals),
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


def leather(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The leather of the upper at texels u (1, W) and v (H, 1): grain, creases, seams, stitches.

    Returns:
        Albedo and optical depth of the finish, (H, W, 3) each, and the leather's height (H, W), in
        the scene's unit of length.
    """
    points = shoe_shape.upper(u, v)
    toe = 0.5 - np.abs(u - 0.5) + 0 * v  # 0.5 at the toe, 0 at the heel
    grain = _grain(points)
    worn = noise.fractal(points * 1.7, 4, seed=5)

    apron = APRON + 0.30 * stage.smoothstep(0.40, 0.24, toe)  # it climbs towards the instep
    ridge = np.exp(-(((v - apron) / 0.016) ** 2)) * stage.smoothstep(0.22, 0.26, toe)
    pleats = 0.5 + 0.5 * np.cos(2 * np.pi * 150 * u)
    strap = stage.smoothstep(STRAP[0] - 0.006, STRAP[0] + 0.006, v + 0 * u)
    strap *= stage.smoothstep(STRAP[1] + 0.006, STRAP[1] - 0.006, v + 0 * u)
    strap *= stage.smoothstep(0.215, 0.225, toe)
    window = (np.abs(u - 0.5) < 0.035) & (np.abs(v - 0.80) < 0.035)
    stitches = _stitches(u, v, 0.955) + _stitches(u, v, 0.045)
    stitches += (strap > 0.5) * (
        _stitches(u, v, STRAP[0] + 0.018) + _stitches(u, v, STRAP[1] - 0.018)
    )
    flex = stage.smoothstep(0.35, 0.0, np.abs(points[..., 0] - 0.55) * 2) * (v > 0.3)
    creases = flex * noise.fractal(points * [9, 1.5, 5], 3, seed=9)

    height = 0.0022 * grain + 0.012 * creases + 0.032 * ridge * (0.6 + 0.4 * pleats)
    height += 0.034 * strap * (1 - window) + 0.006 * stitches

    # Polish gathers in folds and at the ends of the shoe: there it is dark and deep.
    burnt = stage.smoothstep(0.30, 0.49, toe) * (1 - 0.5 * v) + stage.smoothstep(0.10, 0.0, toe)
    burnt = np.clip(burnt * 0.85 + 0.25 * worn + 0.35 * stage.smoothstep(0.10, 0.0, v), 0, 1)
    folds = np.clip(0.5 * (1 - grain) + 0.9 * ridge * (1 - pleats) + 1.0 * window, 0, 1)
    light, dark = np.array([0.86, 0.42, 0.15]), np.array([0.42, 0.10, 0.04])
    albedo = light + (dark - light) * burnt[..., None]
    thread = stitches[..., None]
    albedo = albedo * (1 - 0.25 * folds[..., None])
    albedo = albedo + (np.array([0.95, 0.85, 0.62]) - albedo) * thread
    depth = np.array([0.35, 0.6, 0.9]) * (1 + 2.6 * burnt[..., None] + 0.8 * folds[..., None])
    return albedo, depth * (1 + thread), height


def relief(points: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Normal map (H, W, 3) of heights (H, W) on a surface with the points (H, W, 3)."""
    along_u, along_v = (np.linalg.norm(d, axis=-1) for d in derivatives(points))
    return normal_map(height, np.maximum(along_u, 0.2), np.maximum(along_v, 0.2), closed=True)


def _grain(points: np.ndarray) -> np.ndarray:
    """Grain of the leather at points (..., 3): 1 on the pebbles, 0 in the furrows between them."""
    bent = points + 0.02 * noise.fractal(points * 8, 2, seed=2)[..., None]
    first, second = noise.cells(bent * 24, seed=4)
    return stage.smoothstep(0.0, 0.35, second - first)


def _stitches(u: np.ndarray, v: np.ndarray, line: float) -> np.ndarray:
    """A dashed line along u at v = line."""
    dash = stage.smoothstep(-0.2, 0.3, np.cos(2 * np.pi * 170 * u))
    return dash * np.exp(-(((v - line) / 0.006) ** 4))
