"""The scene "still-life": glazed, lacquered and enamelled objects on a table of varnished wood.

The objects vary the roughness and the index of the coats (the three beads in front), the albedo and
the depth of the medium (fruit, vase and plate), the bottom (metals, clay, wood), and the relief
(the hammered bowl).
"""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import stage, still_life_objects
from gallery.grids import derivatives, grid
from gallery.mesh import Profile, lathe
from gallery.options import Options
from gallery.relief import normal_map
from gallery.stage import Folder, Light, rgb

#: Number of rows of the largest textures.
ROWS = 512
#: The beads: positions, GGX widths and indices of their coats, and their media.
BEADS = [
    ((-0.98, -1.42), 0.02, 1.9, (0.10, 0.30, 0.85), (2.4, 1.6, 0.5)),
    ((-0.42, -1.62), 0.15, 1.5, (0.12, 0.65, 0.40), (2.2, 0.6, 1.4)),
    ((0.14, -1.46), 0.40, 1.3, (0.85, 0.25, 0.15), (0.4, 1.8, 2.2)),
]
BEAD = 0.21


def still_life(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.36, 0.42, 0.54),
            horizon=(0.44, 0.39, 0.34),
            ground=(0.05, 0.045, 0.04),
            lights=[
                Light((-5.2, -2.6, 3.9), (0.40, 0.48), (10.5, 10.2, 9.9)),
                Light((4.6, -2.2, 2.2), (0.24, 0.42), (5.5, 4.6, 3.7)),
            ],
        ),
        "wall": folder.mesh("wall", _wall()) | {"bsdf": stage.diffuse(0.24, 0.21, 0.19)},
        "table": _table(folder, options),
        "vase": _vase(folder, options),
        "plate": _plate(folder, options),
        "bowl": _bowl(folder, options),
    }
    parts |= _fruit(folder, options)
    for index, ((x, y), alpha, eta, albedo, depth) in enumerate(BEADS):
        parts[f"bead-{index}"] = {
            "type": "sphere",
            "center": [x, y, BEAD],
            "radius": BEAD,
            "bsdf": options.coated(
                stage.conductor("Ag", 0.25),
                alpha=alpha,
                int_ior=eta,
                albedo=rgb(*albedo),
                sigma_t=rgb(*depth),
            ),
        }
    view = stage.camera(options, (0.2, -7.6, 3.0), (0.02, 0, 0.86), 31)
    return stage.scene(view, parts)


def _wall():
    """A wall behind the table."""
    x, z = np.meshgrid([-12.0, 12.0], [-3.0, 9.0])
    return grid(np.stack([x, np.full_like(x, 2.6), z], axis=-1))


def _table(folder: Folder, options: Options) -> dict[str, Any]:
    """Boards under a clear varnish that yellows a little."""
    size, (wide, deep) = options.texels(ROWS), (9.0, 4.4)
    x, y = np.meshgrid(
        wide * ((np.arange(2 * size) + 0.5) / (2 * size) - 0.5),
        deep * ((np.arange(size) + 0.5) / size - 0.5),
    )
    corner = np.array([(-wide / 2, -2.4), (wide / 2, deep - 2.4)])
    points = np.zeros((2, 2, 3))
    points[..., 0], points[..., 1] = np.meshgrid(corner[:, 0], corner[:, 1])
    return folder.mesh("table", grid(points)) | {
        "bsdf": options.coated(
            {
                "type": "diffuse",
                "reflectance": folder.texture("wood", still_life_objects.wood(x, y)),
            },
            alpha=0.09,
            int_ior=1.5,
            albedo=rgb(0.8, 0.5, 0.2),
            sigma_t=rgb(0.05, 0.15, 0.35),
        ),
    }


def _vase(folder: Folder, options: Options) -> dict[str, Any]:
    """Stoneware: iron painting on pale clay under a celadon glaze that has run down."""
    profile = Profile(np.array(still_life_objects.VASE))
    rows = options.texels(ROWS)
    points = still_life_objects.texels(profile, rows)
    depth, albedo = still_life_objects.celadon(points)
    return folder.mesh("vase", lathe(profile, 192, 320)) | {
        "to_world": mi.ScalarTransform4d().translate([-1.12, 0.75, 0]),
        "bsdf": options.coated(
            {
                "type": "diffuse",
                "reflectance": folder.texture("clay", still_life_objects.clay(points)),
            },
            alpha=0.04,
            int_ior=1.55,
            albedo=folder.texture("glaze-albedo", albedo),
            sigma_t=folder.texture("glaze-depth", depth),
        ),
    }


def _plate(folder: Folder, options: Options) -> dict[str, Any]:
    """A lacquered plate that leans on the wall, with golden waves under red and black lacquer."""
    profile = Profile(np.array(still_life_objects.PLATE))
    points = still_life_objects.texels(profile, options.texels(2 * ROWS) // 2)
    depth, albedo = still_life_objects.waves(points)
    transform = mi.ScalarTransform4d()
    return folder.mesh("plate", lathe(profile, 192, 256)) | {
        "to_world": transform.translate([0.62, 1.55, 0.93]) @ transform.rotate([1, 0, 0], 76),
        "bsdf": options.coated(
            stage.conductor("Au", 0.22),
            alpha=0.04,
            int_ior=1.5,
            albedo=folder.texture("waves-albedo", albedo),
            sigma_t=folder.texture("waves-depth", depth),
        ),
    }


def _bowl(folder: Folder, options: Options) -> dict[str, Any]:
    """Hammered copper under a tinted varnish."""
    profile = Profile(np.array(still_life_objects.BOWL))
    points = still_life_objects.texels(profile, options.texels(ROWS))
    along_u, along_v = (np.linalg.norm(d, axis=-1) for d in derivatives(points))
    relief = normal_map(
        still_life_objects.hammered(points),
        np.maximum(along_u, 0.3),
        np.maximum(along_v, 0.3),
        closed=True,
    )
    return folder.mesh("bowl", lathe(profile, 192, 256)) | {
        "to_world": mi.ScalarTransform4d().translate([1.12, -0.25, 0]),
        "bsdf": {
            "type": "normalmap",
            "normalmap": folder.texture("bowl-relief", relief),
            "bsdf": options.coated(
                stage.conductor("Cu", 0.18),
                alpha=0.06,
                int_ior=1.5,
                albedo=rgb(0.9, 0.5, 0.25),
                sigma_t=rgb(0.10, 0.30, 0.55),
            ),
        },
    }


def _fruit(folder: Folder, options: Options) -> dict[str, Any]:
    """Apples: the medium's albedo varies from green to red, over a pale bottom."""
    profile = Profile(np.array(still_life_objects.APPLE))
    mesh = folder.mesh("apple", lathe(profile, 128, 192))
    stem = folder.mesh("stem", still_life_objects.stem())
    points = still_life_objects.texels(profile, options.texels(ROWS) // 2)
    places = [
        ((0.93, -0.28, 0.33), (20, -12, 30)),
        ((1.38, -0.12, 0.36), (-14, 18, 160)),
        ((-0.34, -0.42, 0.0), (0, 0, 250)),
    ]
    parts: dict[str, Any] = {}
    transform = mi.ScalarTransform4d()
    for index, (place, (x, y, z)) in enumerate(places):
        placed = (
            transform.translate(list(place))
            @ transform.rotate([1, 0, 0], x)
            @ transform.rotate([0, 1, 0], y)
            @ transform.rotate([0, 0, 1], z)
        )
        albedo, depth = still_life_objects.skin(points, seed=index)
        parts[f"apple-{index}"] = mesh | {
            "to_world": placed,
            "bsdf": options.coated(
                stage.diffuse(0.85, 0.78, 0.50),
                alpha=0.12 + 0.06 * index,
                int_ior=1.4,
                albedo=folder.texture(f"apple-albedo-{index}", albedo),
                sigma_t=folder.texture(f"apple-depth-{index}", depth),
            ),
        }
        parts[f"stem-{index}"] = stem | {
            "to_world": placed,
            "bsdf": stage.diffuse(0.10, 0.06, 0.03),
        }
    return parts
