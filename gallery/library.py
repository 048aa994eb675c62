"""The scene "library": spheres of all materials that `urushi materials` lists, in its order.

The materials are codes, layer by layer, and files of the plugin `neural_brdf`.
"""

from typing import Any

import mitsuba as mi

import urushi
from gallery import stage
from gallery.options import Options
from gallery.stage import Folder, Light
from urushi.app.describe import describe, library

#: Spheres of a row, and distances of their centres along a row and between rows; radius 1.
COLUMNS, ACROSS, DEEP = 6, 2.5, 2.7


def library_spheres(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.20, 0.21, 0.23),
            horizon=(0.34, 0.34, 0.34),
            ground=(0.05, 0.05, 0.05),
            lights=[
                Light((-6.0, -4.0, 9.0), (0.55, 0.45), (6.0, 6.0, 6.1)),
                Light((9.0, -3.0, 4.0), (0.14, 0.70), (4.0, 4.0, 4.1)),
                Light((0.0, 9.0, 4.0), (0.70, 0.12), (2.0, 2.0, 2.0)),
            ],
        ),
        "table": stage.table(60.0, 0.16, 0.16, 0.16),
    }
    for index, name in enumerate(library()):
        row, column = divmod(index, COLUMNS)
        path = folder.path / f"{name.replace(' ', '-')}.safetensors"
        urushi.encode(describe(name)).save(path)
        parts[f"sphere-{index}"] = {
            "type": "sphere",
            "to_world": mi.ScalarTransform4d()
            .translate([(column - 0.5 * (COLUMNS - 1)) * ACROSS, (1.5 - row) * -DEEP, 1.0])
            .rotate([1, 0, 0], 25),
            "bsdf": {"type": "neural_brdf", "filename": str(path)},
        }
    view = stage.camera(options, (0.0, -18.5, 15.5), (0.0, -0.45, 0.6), 42.0)
    return stage.scene(view, parts)
