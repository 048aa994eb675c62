"""The scene "bells": hand bells of turned brass, one under amber varnish, on a brushed tray.

All materials are OpenPBR. The small bell and the tray are clean metal. The scratches of the bells
lie round their axes, as a lathe leaves them, and those of the tray are straight. OpenPBR's tangent
is the direction of the wider highlight, and so lies across the scratches.
"""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import noise, stage
from gallery.brushed import straightened
from gallery.mesh import Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, Light

#: Texels of the bells' textures along their outline, and of the tray's along a side.
TEXELS = 512

#: Colours of brass and of dark bronze, at normal incidence.
BRASS, BRONZE = (0.89, 0.77, 0.42), (0.36, 0.31, 0.26)

#: Colour of the varnish: of light that passes it twice.
AMBER = (0.95, 0.58, 0.17)


def bells(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    transform = mi.ScalarTransform4d()
    large = transform.translate([-0.62, 0.25, TRAY[-1][1]]).rotate([0, 0, 1], 40)
    small = transform.translate([1.12, -0.55, TRAY[-1][1]]).scale(0.62)
    bell = folder.mesh("bell", lathe(Profile(np.array(BELL)), 256, 384))
    handle = folder.mesh("handle", lathe(Profile(np.array(HANDLE)), 128, 256))
    turned = _scratches(folder, options, "turned", (0, 140), 0.49)
    wood = _wood(folder, options)
    varnish = {
        "coat_weight": 1.0,
        "coat_color": stage.rgb(*AMBER),
        "coat_roughness": 0.16,
        "coat_ior": 1.52,
    }
    tray = straightened(lathe(Profile(np.array(TRAY)), 256, 192))
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.10, 0.12, 0.16),
            horizon=(0.13, 0.12, 0.11),
            ground=(0.05, 0.045, 0.04),
            lights=[
                Light((-5.0, -3.0, 4.6), (0.15, 0.30), (17.0, 16.0, 14.4)),
                Light((6.0, -0.6, 2.6), (0.07, 0.50), (9.0, 10.0, 11.5)),
                Light((-2.5, 6.0, 3.4), (0.40, 0.12), (4.2, 4.0, 3.7)),
            ],
        ),
        "table": stage.table(80.0, 0.032, 0.043, 0.054),
        "tray": folder.mesh("tray", tray)
        | {
            "to_world": transform.translate([0.12, 0, 0]).rotate([0, 0, 1], 24),
            "bsdf": options.openpbr(
                **_metal(BRONZE), **_scratches(folder, options, "brushed", (3, 90), 0.50)
            ),
        },
        "bell": bell
        | {"to_world": large, "bsdf": options.openpbr(**_metal(BRASS), **turned, **varnish)},
        "small-bell": bell
        | {"to_world": small, "bsdf": options.openpbr(**_metal(BRASS), **turned)},
        "handle": handle | {"to_world": large, "bsdf": wood},
        "small-handle": handle | {"to_world": small, "bsdf": wood},
    }
    view = stage.camera(options, (0.6, -9.0, 4.5), (0.12, 0.0, 0.99), 32.4)
    return stage.scene(view, parts)


def _metal(color: tuple[float, float, float]) -> dict[str, Any]:
    """The parameters of a clean metal."""
    return {
        "base_metalness": 1.0,
        "base_color": stage.rgb(*color),
        "specular_roughness_anisotropy": 0.85,
    }


def _scratches(
    folder: Folder, options: Options, name: str, frequency: tuple[int, int], roughness: float
) -> dict[str, Any]:
    """Roughness and tangents of scratches along u; frequency: of their noise along u and v."""
    count = options.texels(TEXELS)
    fractions = (np.arange(count) + 0.5) / count
    # Scratches that close round an axis do not change along u.
    u, v = np.meshgrid(fractions if frequency[0] else fractions[:8], fractions)
    lines = noise.fractal(np.stack([frequency[0] * u, frequency[1] * v, 0 * v], axis=-1), 3, seed=7)
    turn = 0.06 * noise.fractal(np.stack([frequency[0] * u, 20 * v, 0 * v], axis=-1), 2, seed=8)
    tangents = np.stack([np.sin(turn), np.cos(turn), 0 * turn], axis=-1)
    return {
        "specular_roughness": folder.texture(
            f"{name}-roughness", np.clip(roughness * (1 + 0.30 * lines), 0.25, 0.7)
        ),
        "geometry_tangent": folder.texture(f"{name}-tangents", 0.5 + 0.5 * tangents),
    }


def _wood(folder: Folder, options: Options) -> dict[str, Any]:
    """Dark turned wood, whose grain runs along the handle, under a clear varnish."""
    count = options.texels(TEXELS)
    u, v = np.meshgrid((np.arange(count) + 0.5) / count, (np.arange(count) + 0.5) / count)
    turn = 2 * np.pi * u
    grain = noise.fractal(np.stack([3 * np.cos(turn), 3 * np.sin(turn), 2 * v], axis=-1), 4, seed=3)
    dark, light = np.array([0.030, 0.011, 0.006]), np.array([0.16, 0.055, 0.022])
    amount = stage.smoothstep(-0.5, 0.5, grain)[..., None]
    return options.openpbr(
        base_color=folder.texture("wood", dark + (light - dark) * amount),
        specular_roughness=0.5,
        coat_weight=1.0,
        coat_roughness=0.22,
        coat_color=stage.rgb(0.95, 0.80, 0.60),
    )


#: Outlines of a bell, of its handle, and of the tray.
BELL = [
    (0.0, 0.0),
    (0.50, 0.0),
    (0.95, 0.0),
    (1.005, 0.0),
    (1.03, 0.03),
    (1.025, 0.075),
    (0.98, 0.135),
    (0.915, 0.22),
    (0.885, 0.268),
    (0.882, 0.280),
    (0.897, 0.292),
    (0.893, 0.325),
    (0.862, 0.338),
    (0.848, 0.342),
    (0.800, 0.44),
    (0.735, 0.60),
    (0.690, 0.78),
    (0.660, 0.95),
    (0.652, 1.000),
    (0.651, 1.010),
    (0.666, 1.020),
    (0.664, 1.050),
    (0.642, 1.062),
    (0.634, 1.068),
    (0.605, 1.16),
    (0.53, 1.275),
    (0.40, 1.345),
    (0.26, 1.375),
    (0.185, 1.39),
    (0.165, 1.42),
    (0.160, 1.47),
    (0.150, 1.50),
    (0.08, 1.50),
    (0.0, 1.50),
]
HANDLE = [
    (0.0, 1.47),
    (0.10, 1.47),
    (0.185, 1.47),
    (0.215, 1.485),
    (0.215, 1.53),
    (0.175, 1.56),
    (0.120, 1.61),
    (0.105, 1.69),
    (0.135, 1.83),
    (0.185, 2.00),
    (0.205, 2.15),
    (0.180, 2.30),
    (0.120, 2.41),
    (0.100, 2.455),
    (0.130, 2.49),
    (0.190, 2.56),
    (0.195, 2.65),
    (0.135, 2.73),
    (0.05, 2.755),
    (0.0, 2.755),
]
TRAY = [
    (0.0, 0.0),
    (1.0, 0.0),
    (2.02, 0.0),
    (2.10, 0.0),
    (2.14, 0.03),
    (2.16, 0.09),
    (2.145, 0.115),
    (2.11, 0.105),
    (2.07, 0.07),
    (2.02, 0.06),
    (1.0, 0.06),
    (0.0, 0.06),
]
