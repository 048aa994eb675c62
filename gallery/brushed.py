"""The scene "brushed": a turned copper bowl under amber lacquer beside a hairline steel watch case.

Both are anisotropic metals under clear or tinted coats. The scratches of the bowl lie round its
axis, as a lathe leaves them; those of the case are straight, as a belt leaves them on its faces and
lugs, and lie round it on its side.
"""

from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np

from gallery import noise, stage
from gallery.grids import grid
from gallery.mesh import Mesh, Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, Light

#: Texels of the bowl's textures along its outline.
TEXELS = 512

#: GGX widths along the scratches and across them: of the lathe, and of the belt.
TURNED, HAIRLINE = (0.06, 0.30), (0.05, 0.26)


def brushed(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    transform = mi.ScalarTransform4d()
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.16, 0.18, 0.22),
            horizon=(0.11, 0.105, 0.10),
            ground=(0.05, 0.045, 0.04),
            lights=[
                Light((-5.0, -4.0, 6.5), (0.16, 0.16), (34.0, 32.0, 29.0)),
                Light((5.5, 3.0, 4.0), (0.10, 0.40), (10.0, 11.2, 13.0)),
                Light((-1.0, 7.0, 3.0), (0.55, 0.12), (6.0, 5.8, 5.5)),
            ],
        ),
        "table": stage.table(16.0, 0.10, 0.085, 0.075),
        "bowl": folder.mesh("bowl", lathe(Profile(np.array(BOWL)), 256, 256))
        | {
            "to_world": transform.translate([-1.0, 0.8, 0]),
            "bsdf": _turned_copper(folder, options),
        },
    }
    placed = transform.translate([1.5, -0.95, 0]).rotate([0, 0, 1], 28).scale(1.15)
    steel = _hairline_steel(options)
    parts |= {
        "case": folder.mesh("case", lathe(Profile(np.array(CASE)), 192, 128))
        | {"to_world": placed, "bsdf": steel},
        "back": folder.mesh("back", straightened(lathe(Profile(np.array(BACK)), 96, 48)))
        | {"to_world": placed, "bsdf": _hairline_steel(options, _hairlines(folder, options))},
        "crown": folder.mesh("crown", lathe(Profile(np.array(CROWN)), 64, 64))
        | {
            "to_world": placed @ transform.translate([0.98, 0, 0.20]).rotate([0, 1, 0], 90),
            "bsdf": steel,
        },
    }
    for number, (x, y) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        parts[f"lug-{number}"] = folder.mesh(f"lug-{number}", lug(x, y)) | {
            "to_world": placed,
            "bsdf": options.coated(stage.conductor("Cr", HAIRLINE[::-1]), alpha=0.02, int_ior=1.45),
        }
    view = stage.camera(options, (0, -8.6, 5.6), (0.14, 0.0, 0.46), 35.5)
    return stage.scene(view, parts)


def _turned_copper(folder: Folder, options: Options) -> dict[str, Any]:
    """Copper with the rings of a lathe under amber lacquer, which is deeper towards the foot."""
    count = options.texels(TEXELS)
    v = (np.arange(count) + 0.5) / count
    rings = noise.fractal(np.stack([v * 160, 0 * v, 0 * v], axis=-1), 3, seed=5)
    across = np.clip(TURNED[1] * (1 + 0.45 * rings), 0.12, 0.5)
    # The outline runs up the outside and down the inside: lacquer gathers at its ends.
    depth = 0.55 + 0.9 * stage.smoothstep(0.30, 0.02, np.minimum(v, 1 - v))
    columns = (8, 1)
    return options.coated(
        stage.conductor(
            "Cu", (TURNED[0], folder.texture("bowl-scratches", np.tile(across, columns).T))
        ),
        alpha=0.04,
        int_ior=1.5,
        albedo=stage.rgb(0.55, 0.30, 0.08),
        sigma_t=folder.texture(
            "bowl-depth", np.tile(depth, columns).T[..., None] * [0.16, 0.75, 2.2]
        ),
    )


def _hairline_steel(options: Options, across: Any = HAIRLINE[1]) -> dict[str, Any]:
    """Steel with hairlines along u under a clear coat; across: its width across them."""
    steel = stage.conductor("Cr", (HAIRLINE[0], across))
    return options.coated(steel, alpha=0.02, int_ior=1.45)


def _hairlines(folder: Folder, options: Options) -> dict[str, Any]:
    """A texture of widths across hairlines along u, some deeper than others."""
    count = options.texels(TEXELS)
    u, v = np.meshgrid((np.arange(count) + 0.5) / count, (np.arange(count) + 0.5) / count)
    lines = noise.fractal(np.stack([3 * u, 45 * v, 0 * v], axis=-1), 3, seed=9)
    return folder.texture("hairlines", np.clip(HAIRLINE[1] * (1 + 0.5 * lines), 0.1, 0.45))


def straightened(mesh: Mesh) -> Mesh:
    """A mesh with texture coordinates by x and y: straight scratches along x."""
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    return replace(mesh, uv=((mesh.positions - low) / (high - low))[:, :2].astype(np.float32))


def lug(x: int, y: int) -> Mesh:
    """One of the horns that hold the strap, in the quarter with the signs x and y.

    A bar with a rounded rectangle across, which u goes round, and bent down along v.
    """
    dense_at_ends = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 65))
    turn, along = np.meshgrid(2 * np.pi * np.arange(65) / 64, dense_at_ends)
    closing = np.sqrt(np.clip(1 - (2 * along - 1) ** 10, 0, 1))  # closes both ends
    wide, high = (np.sign(part) * np.abs(part) ** 0.35 for part in (np.cos(turn), np.sin(turn)))
    lateral = 0.52 * x - 0.12 * y * closing * wide  # the sign of y keeps the front outside
    forward = y * (0.60 + 0.58 * along)
    height = 0.25 - 0.16 * along**2.2 + closing * (0.11 - 0.04 * along) * high
    return grid(np.stack([lateral, forward, height], axis=-1), closed=True)


#: Outlines of the bowl, of the case with a polished edge, of its back, and of the crown.
BOWL = [
    (0.0, 0.0), (0.40, 0.0), (0.62, 0.0), (0.66, 0.05), (0.62, 0.13), (0.80, 0.22), (1.22, 0.42),
    (1.55, 0.80), (1.70, 1.22), (1.76, 1.36), (1.71, 1.38), (1.64, 1.24), (1.47, 0.84),
    (1.15, 0.50), (0.72, 0.31), (0.34, 0.26), (0.0, 0.25),
]  # fmt: skip
CASE = [
    (0.0, 0.02), (0.60, 0.02), (0.90, 0.02), (0.95, 0.03), (0.97, 0.10), (0.97, 0.20),
    (0.97, 0.30), (0.95, 0.37), (0.90, 0.385), (0.84, 0.39), (0.82, 0.385), (0.80, 0.36),
    (0.60, 0.355), (0.0, 0.355),
]  # fmt: skip
BACK = [
    (0.0, 0.30), (0.40, 0.30), (0.74, 0.30), (0.77, 0.34), (0.77, 0.385), (0.75, 0.405),
    (0.40, 0.41), (0.0, 0.41),
]  # fmt: skip
CROWN = [(0.0, 0.0), (0.06, 0.0), (0.09, 0.02), (0.10, 0.10), (0.09, 0.17), (0.0, 0.18)]
