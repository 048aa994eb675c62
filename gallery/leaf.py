"""The scene "leaf": a leaf against the light.

The blade is a slab: a sheet that scatters light forwards and absorbs all but green, under a waxy
surface on both sides. Without a bottom, `neural_layered` has tables of it. The veins are opaque.
"""

from typing import Any

import numpy as np

from gallery import stage
from gallery.grids import grid
from gallery.mesh import Mesh
from gallery.options import Options
from gallery.stage import Folder, Light, rgb

#: Length of the blade, and half of its greatest width.
LENGTH, WIDTH = 3.2, 1.05
#: Pairs of veins, and how far a vein of the margin lies ahead of its root, in lengths.
VEINS, AHEAD = 9, 0.16


def leaf(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    along, across = np.linspace(0, 1, 161), np.linspace(-1, 1, 81)
    blade = grid(blade_at(*np.meshgrid(along, across, indexing="ij")))
    green = {
        "type": options.coat,
        "alpha": 0.25,
        "int_ior": 1.45,
        "albedo": rgb(0.80, 0.96, 0.30),
        "sigma_t": rgb(5.0, 4.0, 6.0),
        "g": 0.75,
    }
    stalk = options.coated(
        stage.diffuse(0.30, 0.32, 0.07),
        alpha=0.2,
        int_ior=1.45,
    )
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.30, 0.38, 0.52),
            horizon=(0.20, 0.24, 0.20),
            ground=(0.05, 0.06, 0.03),
            lights=[
                Light((-1.6, 4.0, 2.6), (0.16, 0.16), (60.0, 54.0, 42.0)),
                Light((2.0, -4.0, 4.0), (0.30, 0.30), (7.0, 7.4, 8.0)),
            ],
        ),
        "blade": folder.mesh("blade", blade) | {"bsdf": green},
    }
    for name, vein in veins().items():
        parts[name] = folder.mesh(name, vein) | {"bsdf": stalk}
    view = stage.camera(options, (0.2, -8.2, 0.4), (0.05, 0.0, -0.22), 32.0)
    return stage.scene(view, parts)


def blade_at(along: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the blade: `along` in [0, 1] from the stalk, `across` in [-1, 1]."""
    half = WIDTH * np.sin(np.pi * along**0.75) ** 0.8 * (1 - 0.35 * along)
    x = half * across
    ripple = 0.035 * np.sin(2 * np.pi * (VEINS * (along - AHEAD * np.abs(across)))) * across**2
    # Both halves are folded towards the viewer, and the tip hangs.
    y = -0.30 * np.abs(x) - 0.45 * (along - 0.35) ** 2 + ripple
    z = LENGTH * (along - 0.5) * np.cos(0.25)
    tilt = 0.35
    return np.stack(
        [np.cos(tilt) * x - np.sin(tilt) * z, y, np.sin(tilt) * x + np.cos(tilt) * z], -1
    )


def veins() -> dict[str, Mesh]:
    """The midrib with the stalk, and the veins on both sides."""
    along = np.linspace(-0.28, 0.98, 120)
    line = blade_at(np.maximum(along, 0), np.zeros_like(along))
    start = blade_at(np.array([0.0, 0.02]), np.zeros(2))
    line += np.minimum(along, 0)[:, None] * (start[1] - start[0]) / 0.02
    found = {"midrib": tube(line, 0.035 * (1.05 - np.maximum(along, 0)))}
    for side in (-1, 1):
        for i, root in enumerate(np.linspace(0.06, 0.80, VEINS)):
            part = np.linspace(0, 0.93, 40)
            line = blade_at(root + AHEAD * part**1.3, side * part)
            found[f"vein-{i}-{'left' if side < 0 else 'right'}"] = tube(line, 0.012 * (1.1 - part))
    return found


def tube(line: np.ndarray, radius: np.ndarray) -> Mesh:
    """A tube of radii (N,) along a line of points (N, 3)."""
    ahead = np.gradient(line, axis=0)
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    side = np.cross(ahead, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    turn = np.linspace(0, 2 * np.pi, 13)[None, :, None]
    ring = np.cos(turn) * side[:, None] + np.sin(turn) * np.cross(side, ahead)[:, None]
    return grid(line[:, None] + radius[:, None, None] * ring, closed=True)
