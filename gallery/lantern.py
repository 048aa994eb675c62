"""The scene "lantern": a lacquered paper lantern, lit from inside.

The paper is a slab: a sheet that scatters light, under smooth lacquer on both sides. The ribs of
bamboo show as its folds. Without a bottom, `neural_layered` has tables of it.
"""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import stage
from gallery.mesh import Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, Light

#: Half of the lantern's height, its largest radius, and the radius of its openings.
HEIGHT, RADIUS, OPENING = 1.25, 1.0, 0.5
#: Ribs of bamboo, and how deep the paper sinks between them.
RIBS, FOLD = 13, 0.035
#: Height of the middle of the lantern, which hangs above the table.
MIDDLE = 1.55


def lantern(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    transform = mi.ScalarTransform4d()
    paper = {
        "type": options.coat,
        "alpha": 0.12,
        "int_ior": 1.5,
        "albedo": stage.rgb(0.995, 0.97, 0.80),
        "sigma_t": stage.rgb(5.0, 6.0, 8.0),
        "g": 0.3,
    }
    wood = options.coated(stage.diffuse(0.20, 0.02, 0.012), alpha=0.05, int_ior=1.52)
    glow = {"type": "area", "radiance": stage.rgb(16.0, 12.5, 8.5)}
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.016, 0.022, 0.042),
            horizon=(0.035, 0.040, 0.060),
            ground=(0.006, 0.006, 0.006),
            lights=[Light((-4.0, -3.5, 3.0), (0.25, 0.40), (5.0, 5.6, 6.8))],
        ),
        "table": stage.table(60.0, 0.16, 0.11, 0.085),
        "paper": folder.mesh("paper", lathe(Profile(_outline()), 384, 768)) | {"bsdf": paper},
        "flame": {
            "type": "sphere",
            "center": [0, 0, MIDDLE],
            "radius": 0.42,
            "emitter": glow,
        },
    }
    for name, height in (("foot", MIDDLE - HEIGHT), ("cap", MIDDLE + HEIGHT)):
        ring = lathe(Profile(np.array(RING)), 256, 96)
        place = transform.translate([0, 0, height - 0.09])
        parts[name] = folder.mesh(name, ring) | {"to_world": place, "bsdf": wood}
    view = stage.camera(options, (0.9, -8.6, 2.7), (0.0, 0.0, 1.5), 29.0)
    return stage.scene(view, parts)


def _outline() -> np.ndarray:
    """Control points of the paper, from the middle of its foot to that of its top."""
    places = np.linspace(-1, 1, 12 * RIBS + 1)
    barrel = OPENING + (RADIUS - OPENING) * np.sqrt(np.maximum(1 - np.abs(places) ** 2.6, 0))
    folds = FOLD * np.abs(np.sin(np.pi * RIBS * (places + 1) / 2))
    side = np.stack([barrel - folds, MIDDLE + HEIGHT * places], axis=1)
    bottom, top = ([0.0, MIDDLE + sign * HEIGHT] for sign in (-1, 1))
    return np.concatenate([[bottom], side, [top]])


#: Outline of the wooden rings.
RING = [(0.0, 0.0), (0.40, 0.0), (0.56, 0.0), (0.60, 0.04), (0.60, 0.14), (0.56, 0.18)]
RING += [(0.40, 0.18), (0.0, 0.18)]
