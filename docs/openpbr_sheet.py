"""Renders a sphere of each example of OpenPBR that the plugin `openpbr` has, on one sheet.

usage: python docs/openpbr_sheet.py FOLDER PICTURE

FOLDER is `examples` of the repository AcademySoftwareFoundation/OpenPBR. Spheres are in the order
of the names that are printed, row by row; materials that are refused are printed with the reason.
"""

import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import mitsuba as mi
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from gallery import stage

import urushi
from urushi.errors import UrushiWarning

SIZE, COLUMNS, SAMPLES = 128, 8, 128

#: Radiance of the zenith, the horizon and the ground.
SKY = (0.5, 0.52, 0.56), (0.3, 0.3, 0.3), (0.08, 0.07, 0.06)

LAMPS = (
    stage.Light(towards=(-1.0, -0.7, 0.9), size=(0.35, 0.35), radiance=(9.0, 9.0, 9.0)),
    stage.Light(towards=(1.2, -0.3, 0.3), size=(0.1, 0.55), radiance=(7.0, 6.0, 4.5)),
    stage.Light(towards=(0.2, 1.0, 0.6), size=(0.5, 0.12), radiance=(4.4, 6.0, 8.0)),
)


def sphere(surface: urushi.OpenPBR) -> np.ndarray:
    """The picture (SIZE, SIZE, 3) of a sphere in a studio of three softboxes, linear sRGB."""
    look = mi.ScalarTransform4f().look_at([0, -4, 0.6], [0, 0, 0], [0, 0, 1])
    with TemporaryDirectory() as folder:
        sky = stage.surround(stage.Folder(Path(folder)), *SKY, LAMPS)
        return _render(surface, sky, look)


def _render(surface: urushi.OpenPBR, sky: dict, look: "mi.ScalarTransform4f") -> np.ndarray:
    scene = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 64},
        "sensor": {
            "type": "perspective",
            "fov": 30,
            "to_world": look,
            "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "pixel_format": "rgb"},
        },
        "sky": sky,
        "object": surface.on({"type": "sphere"}),
    }
    return np.array(mi.render(mi.load_dict(scene), spp=SAMPLES))


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
    # Lights of thousands of nits would become black in a file of bytes.
    sheet = np.minimum(np.concatenate(rows), 1).astype(np.float32)
    mi.util.write_bitmap(str(picture), sheet, write_async=False)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
