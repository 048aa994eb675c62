"""Textures of alpha and index for the coats of the still life.

The still life varies both from object to object, and within an object the medium only. Here both
vary from texel to texel, as in Figure 1 of Fan et al. (2022): crystals in the glaze of the vase,
bands on the plate, stripes on the beads, wear on bowl and table.
"""

from pathlib import Path
from typing import Any

import numpy as np
from gallery import noise
from gallery.options import Options
from gallery.stage import Folder, smoothstep

#: Ranges of the textures: GGX widths, and indices of refraction.
ALPHAS, INDICES = (0.03, 0.45), (1.3, 1.9)
#: Texels along a side of a texture.
TEXELS = 512


def applied(scene: dict[str, Any], folder: Path, options: Options) -> dict[str, Any]:
    """The scene "still-life" with textures of alpha and index on vase, plate, bowl, table, beads.

    Args:
        scene, folder, options: the description, its folder, and its options.
    """
    files, side = Folder(folder), options.texels(TEXELS)
    v, u = np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2, indexing="ij")
    around = np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3 * v], axis=-1)
    spots = smoothstep(-0.1, 0.15, noise.fractal(2 * around, 3, seed=31))
    wear = smoothstep(-0.3, 0.5, noise.fractal(around * 4, 4, seed=32))
    bands = smoothstep(-0.25, 0.25, np.sin(2 * np.pi * 10 * v))
    stripes = smoothstep(-0.25, 0.25, np.sin(2 * np.pi * 4 * u))
    patterns = {
        "vase": (spots, 1 - spots),
        "plate": (wear, bands),
        "bowl": (wear, spots),
        "table": (wear, wear),
        **{f"bead-{index}": (stripes, spots) for index in range(3)},
    }
    result = dict(scene)
    for name, (of_alpha, of_index) in patterns.items():
        textures = {
            "alpha": files.texture(f"{name}-alpha", _between(ALPHAS, of_alpha)),
            "int_ior": files.texture(f"{name}-index", _between(INDICES, of_index)),
        }
        result[name] = _with(scene[name], options.coat, textures)
    return result


def _between(ends: tuple[float, float], share: np.ndarray) -> np.ndarray:
    """Values between two ends, spaced evenly in the logarithm."""
    return ends[0] * (ends[1] / ends[0]) ** share


def _with(node: dict[str, Any], coat: str, textures: dict[str, Any]) -> dict[str, Any]:
    """The node with these parameters in the coat that it holds."""
    if node.get("type") == coat:
        return {**node, **textures}
    return {
        key: _with(value, coat, textures) if isinstance(value, dict) else value
        for key, value in node.items()
    }
