"""The scene "glass": stoppers of tinted glass: frosted under a clear coat, frosted, and clear.

They are bodies: `transmission_weight` of OpenPBR, with a medium inside that absorbs. The coat fills
the frosted surface: it shines, and what is seen through it is less blurred.
"""

from typing import Any

import mitsuba as mi
import numpy as np

import urushi
from gallery import stage
from gallery.mesh import Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, Light, rgb

#: Outline of a stopper: half of a closed body, from the middle of its foot.
BODY = [(0.0, 0.0), (0.50, 0.0), (0.74, 0.02), (0.80, 0.10), (0.80, 0.30), (0.76, 0.60)]
BODY += [(0.62, 0.92), (0.38, 1.14), (0.22, 1.30), (0.20, 1.48), (0.30, 1.62), (0.36, 1.78)]
BODY += [(0.28, 1.94), (0.12, 2.00), (0.0, 2.0)]

#: The glass: its colour is that of light after the width of the foot.
GLASS = {
    "transmission_weight": 1.0,
    "transmission_color": rgb(0.20, 0.62, 0.56),
    "transmission_depth": 1.2,
    "specular_ior": 1.5,
}


def glass(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.80, 0.84, 0.92),
            horizon=(0.75, 0.70, 0.64),
            ground=(0.16, 0.15, 0.14),
            lights=[
                Light((-4.0, -2.5, 3.4), (0.45, 0.60), (3.2, 3.1, 2.9)),
                Light((4.0, 1.2, 3.0), (0.60, 0.50), (2.6, 2.8, 3.0)),
            ],
        ),
        "table": stage.table(8.0, 0.42, 0.34, 0.26),
    }
    body = folder.mesh("body", lathe(Profile(np.array(BODY)), 192, 256))
    body |= {"interior": urushi.openpbr(**GLASS).interior()}
    coat = {"coat_weight": 1.0, "coat_roughness": 0.1, "coat_ior": 1.4}
    for i, (name, surface) in enumerate(
        {
            "coated": {"specular_roughness": 0.55, **coat},
            "frosted": {"specular_roughness": 0.55},
            "clear": {"specular_roughness": 0.1},
        }.items()
    ):
        place = mi.ScalarTransform4d().translate([1.9 * (i - 1), 0, 0.004])
        bsdf = options.openpbr(**GLASS, **surface, interior=True)
        parts[name] = body | {"to_world": place, "bsdf": bsdf}
    view = stage.camera(options, (0.0, -8.4, 2.9), (0.0, 0.0, 0.92), 36.0)
    described = stage.scene(view, parts)
    return described | {"integrator": {"type": "volpathmis", "max_depth": 24}}
