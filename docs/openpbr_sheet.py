"""Renders a sphere of each example of OpenPBR that the plugin `openpbr` has, on one sheet.

usage: python docs/openpbr_sheet.py FOLDER PICTURE

FOLDER is `examples` of the repository AcademySoftwareFoundation/OpenPBR. Spheres are in the order
of the names that are printed, row by row; materials that are refused are printed with the reason.
"""

import sys
import warnings
from pathlib import Path

import mitsuba as mi
import numpy as np

import urushi
from urushi.errors import UrushiWarning

SIZE, COLUMNS, SAMPLES = 128, 8, 64


def sphere(surface: urushi.OpenPBR) -> np.ndarray:
    """The picture (SIZE, SIZE, 3) of a sphere under a lamp and even light, linear sRGB."""
    look = mi.ScalarTransform4f().look_at([0, 1, 4], [0, 0, 0], [0, 1, 0])
    lamp = {"type": "area", "radiance": {"type": "rgb", "value": 12.0}}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 4},
        "sensor": {
            "type": "perspective",
            "fov": 30,
            "to_world": look,
            "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.3}},
        "lamp": {"type": "sphere", "center": [3, 5, 4], "radius": 1.0, "emitter": lamp},
        "object": surface.on({"type": "sphere"}),
    }
    return np.array(mi.render(mi.load_dict(scene), spp=SAMPLES))[..., :3]


def main(folder: Path, picture: Path) -> None:
    mi.set_variant("llvm_ad_rgb")
    pictures = []
    for path in sorted(folder.glob("*.mtlx")):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UrushiWarning)  # colours outside of sRGB
            surface = urushi.openpbr(**urushi.load_materialx(path))
        try:
            pictures.append(sphere(surface))
            print(path.stem)
        except RuntimeError as error:  # Mitsuba's, around the plugin's own sentence
            print(f"{path.stem}: refused: {str(error).strip().splitlines()[-1]}")
    empty = np.zeros((SIZE, SIZE, 3))
    pictures += [empty] * (-len(pictures) % COLUMNS)
    rows = [np.concatenate(pictures[i : i + COLUMNS], 1) for i in range(0, len(pictures), COLUMNS)]
    mi.util.write_bitmap(str(picture), np.concatenate(rows).astype(np.float32), write_async=False)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
