"""A sphere of one material in a small studio, rendered by Mitsuba, for comparisons side by side."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mitsuba as mi
import numpy as np
from gallery import stage

SKY = (0.35, 0.36, 0.4), (0.25, 0.24, 0.23), (0.08, 0.07, 0.06)
LAMPS = (
    *(stage.Light((side, -0.6, 0.9), (0.3, 0.3), (9.0, 9.0, 9.0)) for side in (-1.0, 1.0)),
    stage.Light((0.0, -1.0, 0.15), (0.08, 0.08), (12.0, 12.0, 12.0)),
)


def render(bsdf: dict[str, Any], size: int, samples: int, seed: int) -> np.ndarray:
    """The picture (size, size, 3) of a sphere before a black background, linear radiance.

    Args:
        bsdf: description of the material for `mi.load_dict`.
        size: of the picture [pixels].
        samples, seed: samples per pixel, and their seed.
    """
    return np.array(mi.render(load(bsdf, size), spp=samples, seed=seed))


def load(bsdf: dict[str, Any], size: int) -> "mi.Scene":
    """The scene of `render`, for several renders of it."""
    with TemporaryDirectory() as folder:
        look = mi.ScalarTransform4f().look_at([0, -4, 0.6], [0, 0, 0], [0, 0, 1])
        film = {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb"}
        scene = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3, "hide_emitters": True},
            "sensor": {"type": "perspective", "fov": 30, "to_world": look, "film": film},
            "light": stage.surround(stage.Folder(Path(folder)), *SKY, LAMPS),
            "sphere": {"type": "sphere", "bsdf": bsdf},
        }
        return mi.load_dict(scene)
