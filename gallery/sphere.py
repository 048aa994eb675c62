"""Light of the spheres in notebooks: writes surround.exr of `urushi/app/sphere`.

Example: python -m gallery.sphere src/urushi/app/sphere
"""

import sys
from pathlib import Path

import mitsuba as mi

from gallery import stage

#: Radiance of the sky above, at the horizon and below.
SKY = (0.35, 0.36, 0.4), (0.25, 0.24, 0.23), (0.08, 0.07, 0.06)

LIGHTS = (
    stage.Light(towards=(-1.0, -0.6, 0.9), size=(0.35, 0.35), radiance=(9.0, 9.0, 9.0)),
    stage.Light(towards=(1.2, -0.3, 0.3), size=(0.10, 0.55), radiance=(7.0, 6.0, 4.5)),
    stage.Light(towards=(0.2, 1.0, 0.6), size=(0.50, 0.12), radiance=(4.4, 6.0, 8.0)),
)

if __name__ == "__main__":
    mi.set_variant("scalar_rgb")
    stage.surround(stage.Folder(Path(sys.argv[1])), *SKY, LIGHTS)
